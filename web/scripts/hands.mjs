// What tests do with the page, as one would by hand.

/** In software and beside other work a frame takes seconds, and the pipelines before it longer. */
export const WAIT = { timeout: Number(process.env.UMBRAGRAPH_PATIENCE ?? 240_000) };

export const state = (page, wanted) => page.locator(`#state[data-state="${wanted}"]`).waitFor(WAIT);
export const text = (page, id) => page.locator(id).textContent();

/** Replaces a word everywhere in the file that is shown, as one would with the editor's search. */
export async function replace(page, word, by) {
  await page.locator(".cm-content").press("Control+f");
  await page.locator("input[name=search]").fill(word);
  await page.locator("input[name=replace]").fill(by);
  await page.locator("[name=replaceAll]").click();
  await page.locator("[name=close]").click();
}

/** Waits until so many tasks of the step that is shown are solved. */
export const solved = (page, count) =>
  page.waitForFunction((count) => document.querySelectorAll("#course .tasks > .done").length === count, count, WAIT);

export const frames = (page) => page.evaluate(() => Number(document.documentElement.dataset.frames ?? 0));

/** Puts the cursor into a word of the editor, so many characters in, with the editor's search. */
export async function go(page, word, right) {
  const content = page.locator(".cm-content");
  await content.press("Control+Home");
  await content.press("Control+f");
  await page.locator("input[name=search]").fill(word);
  await page.locator("[name=next]").click();
  await page.locator("[name=close]").click();
  await content.press("ArrowLeft");
  for (let at = 0; at < right; at++) await content.press("ArrowRight");
}
