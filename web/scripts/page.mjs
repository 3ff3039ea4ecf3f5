// What one does with the page: edit, mend, undo, break a template, share, see a frame, and go on when a worker dies.
import assert from "node:assert/strict";
import { WAIT, frames, replace, solved, state, text } from "./hands.mjs";
import { access } from "./access.mjs";
import { language } from "./language.mjs";
import { project } from "./project.mjs";

const LESSON = "pipelines/learn/01-smallest.json";
const steps = {
  async "the gallery shows pictures, and one opens live"(page) {
    await page.locator(".card").first().waitFor(WAIT);
    for (const image of await page.locator(".card img").all()) {
      await image.scrollIntoViewIfNeeded();
      await page.waitForFunction((one) => one.complete && one.naturalWidth > 0, await image.elementHandle(), WAIT);
    }
    await page.locator(".card", { hasText: "umbra in a courtyard" }).click();
    await page.locator("#work").waitFor(WAIT);
    assert.equal(await page.inputValue("#pipeline"), "pipelines/umbra.json");
  },

  async "the flagship is valid, and drawn"(page) {
    await state(page, "fine");
    assert.match(await text(page, "#figures"), /^\d+ passes/);
    const begin = performance.now();
    await page.waitForFunction(() => document.documentElement.dataset.frames > 0, null, WAIT);
    const took = await page.getAttribute("#state", "title");
    console.log(`  umbra: ${took}; ${(performance.now() - begin).toFixed(0)} ms more to a frame`);
  },

  async "a saved picture shows the scene"(page) {
    const [download] = await Promise.all([page.waitForEvent("download", WAIT), page.click("#save")]);
    const { decode } = await import("./png.mjs");
    const { readFileSync } = await import("node:fs");
    const { texels } = decode(readFileSync(await download.path()));
    assert.ok(new Set(new Uint32Array(texels.buffer)).size > 1000, "the picture has few colours");
  },

  async "a click on a pass shows what it writes, with numbers"(page) {
    await page.click("#tab-graph");
    // It stands beyond what is in view.
    const pass = page.locator('#graph svg [data-pass="sky"]');
    await pass.focus(WAIT);
    await pass.press("Enter");
    const picture = page.locator("#graph .contents canvas:not([hidden])");
    await picture.waitFor(WAIT);
    const shown = await picture.evaluate((canvas) => {
      const texels = new Uint32Array(canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.buffer);
      return { colors: new Set(texels).size, of: canvas.dataset.shows };
    });
    assert.match(shown.of, /@sky$/);
    assert.ok(shown.colors > 100, `the contents of ${shown.of} have ${shown.colors} colors`);
    await picture.hover({ position: { x: 40, y: 40 } });
    await page.waitForFunction(() => /^\d+, \d+: [-\d.e]+/.test(document.querySelector("#graph .contents output").textContent), null, WAIT);
    await page.locator("#graph .contents select").first().selectOption("color");
    await page.waitForFunction((of) => document.querySelector("#graph .contents canvas").dataset.shows !== of, shown.of, WAIT);
    await page.click("#tab-frame");
  },

  async "a live parameter draws again, and a structural one plans again"(page) {
    const before = await frames(page);
    await page.locator("#parameters-blend").fill("0.4");
    await page.waitForFunction((before) => document.documentElement.dataset.frames > before, before, WAIT);
    const figures = await text(page, "#figures");
    await page.selectOption("#preset", "phone");
    await page.waitForFunction((before) => document.getElementById("figures").textContent !== before, figures, WAIT);
    await state(page, "fine");
  },

  async "an edit is diagnosed at its line, mended, and undone"(page) {
    await page.selectOption("#pipeline", LESSON);
    await page.waitForFunction(() => document.getElementById("figures").textContent.startsWith("1 pass "), null, WAIT);
    await state(page, "fine");
    await replace(page, "gradient.wgsl", "gradiant.wgsl");
    await state(page, "error");
    const place = await text(page, "#problems .where");
    const lines = (await (await page.request.get(new URL("files.json", page.url()).href)).json())[LESSON].split("\n");
    const line = lines.findIndex((one) => one.includes("gradient.wgsl")) + 1;
    assert.equal(place, `${LESSON}:${line}`);
    await page.locator(".cm-lintRange-error").first().waitFor(WAIT);
    await page.locator("#problems .mend").click();
    await state(page, "fine");
    assert.ok(!(await text(page, "#tabs")).includes("•"), "the mended text is the one before");
    await page.locator(".cm-content").press("Control+z");
    await state(page, "error");
    await page.locator(".cm-content").press("Control+z");
    await state(page, "fine");
  },

  async "a broken template is diagnosed in its file"(page) {
    await page.selectOption("#open", "gradient.wgsl.jinja");
    await page.waitForFunction(() => document.querySelector("#tabs [aria-selected=true]").textContent.includes("gradient"), null, WAIT);
    await replace(page, "vec4", "vec5");
    await state(page, "error");
    assert.match(await text(page, "#problems .where"), /gradient\.wgsl\.jinja:\d+/);
    await page.locator(".cm-content").press("Control+z");
    await state(page, "fine");
  },

  async "a link holds what was changed"(page) {
    await page.locator("#tabs [role=tab]").first().click();
    await replace(page, "smallest", "shared");
    await state(page, "fine");
    await page.click("#share");
    await page.waitForFunction(() => location.hash.length > 10, null, WAIT);
    await page.reload();
    await state(page, "fine");
    assert.match(await text(page, "#tabs"), /01-smallest\.json •/);
    assert.match(await text(page, ".cm-content"), /"shared"/);
  },

  async "a checker that dies is started again"(page) {
    await replace(page, "shared", "before");
    await state(page, "fine");
    const checker = page.workers().find((one) => one.url().endsWith("checker.js"));
    // A question that there is not ends the library as a panic does.
    await checker.evaluate(() => self.dispatchEvent(new MessageEvent("message", { data: { id: -1, kind: "nothing" } })));
    await page.locator("#notice:not([hidden])").waitFor(WAIT);
    assert.match(await text(page, "#notice"), /01-smallest\.json/);
    await replace(page, "\"fill\"", "\"fil l\"");
    await state(page, "error");
    await replace(page, "\"fil l\"", "\"fill\"");
    await state(page, "fine");
  },
};

/** Steps of the course by hand: tasks are recognised as solved after an edit, and after a value. */
const course = {
  async "an edit solves a task of the course"(page) {
    await page.locator("#course h2", { hasText: "A culled pass" }).waitFor(WAIT);
    await state(page, "fine");
    await solved(page, 0);
    await replace(page, '"source": "&kept"', '"source": "&painted"');
    await solved(page, 1);
    assert.match(await text(page, "#figures"), /2 passes, 1 culled/);
    await page.locator(".cm-content").press("Control+z");
    await solved(page, 2);
    await page.locator("#course .end").waitFor(WAIT);
  },

  async "a shadow gets soft, and the next frame shows it"(page) {
    await page.goto(new URL("#step=softness", page.url()).href);
    await page.locator("#course h2", { hasText: "softness" }).waitFor(WAIT);
    await page.locator("#parameters-filter_radius").waitFor(WAIT);
    await page.waitForFunction(() => document.documentElement.dataset.frames > 0, null, WAIT);
    const before = await frames(page);
    await page.locator("#parameters-filter_radius").fill("7");
    await solved(page, 1);
    await page.waitForFunction((before) => document.documentElement.dataset.frames > before, before, WAIT);
  },
};

/** Every task of every step has a way to solve it, and is recognised. */
async function whole_course(page) {
  const ids = await page.locator("#course select option").evaluateAll((options) => options.map(({ value }) => value));
  assert.ok(ids.length >= 30, `${ids.length} steps`);
  for (const id of ids) {
    await page.evaluate((id) => (location.hash = `#step=${id}`), id);
    await page.waitForFunction((id) => document.querySelector("#course select").value === id, id, WAIT);
    const tasks = await page.locator("#course .tasks > li").count();
    for (let at = 0; at < tasks; at++) {
      await page.waitForFunction(() => document.getElementById("state").dataset.state, null, WAIT);
      await page.locator("#course .solve").click(WAIT);
      await solved(page, at + 1).catch(() => assert.fail(`${id}: task ${at + 1} is not recognised as solved`));
    }
  }
  await page.goto(new URL("#", page.url()).href);
  await page.waitForFunction((count) => document.querySelectorAll(".steps .solved").length === count, ids.length, WAIT);
  console.log(`  ${ids.length} steps of the course are solved`);
}

/** Goes through the steps; the names of those that fail. */
export async function page_works(browser, { address, site, command }) {
  const failures = [];
  const take = async (name, work) => {
    try {
      await work();
      console.log(`  page: ${name}`);
    } catch (error) {
      console.log(`! page: ${name}: ${error.message}`);
      failures.push(name);
    }
  };
  for (const [fragment, parts] of [["", steps], ["#step=culled", course]]) {
    const page = await browser.newPage({ viewport: { width: 1440, height: 900 } });
    page.on("pageerror", (error) => console.log(`! page: ${error.message}`));
    await page.goto(address + fragment);
    for (const [name, step] of Object.entries(parts)) await take(name, () => step(page));
    await page.close();
  }

  const open = async (fragment) => {
    const context = await browser.newContext({ viewport: { width: 1440, height: 900 } });
    const page = await context.newPage();
    page.on("pageerror", (error) => console.log(`! page: ${error.message}`));
    await page.addInitScript(() => Object.defineProperty(Navigator.prototype, "gpu", { get: () => undefined }));
    await page.goto(address + fragment);
    return page;
  };
  for (const [name, part] of Object.entries({ ...project(command, open), ...language(open), ...access(browser, open, site) })) await take(name, part);
  const without = await open("#step=pass");
  await take("without WebGPU it still checks, and says so", async () => {
    await without.locator("#notice:not([hidden])").waitFor(WAIT);
    assert.match(await text(without, "#notice"), /no WebGPU/);
    await state(without, "fine");
  });
  await take("every task of the course can be solved", () => whole_course(without));
  await without.context().close();
  return failures;
}
