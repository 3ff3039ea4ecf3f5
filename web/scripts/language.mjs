// The language server in the page: completion, hover, and a rename that reaches a file that no tab shows.
import assert from "node:assert/strict";
import { WAIT, go, state, text } from "./hands.mjs";

const content = (page) => text(page, ".cm-content");

export const language = (open) => ({
  async "the language server completes a reference"() {
    const page = await open("#pipeline=pipelines/learn/02-resources.json");
    await state(page, "fine");
    await go(page, '"&kept"', 2);
    for (const _ of "kept") await page.locator(".cm-content").press("Delete");
    await page.locator(".cm-content").press("Control+Space");
    const list = page.locator(".cm-tooltip-autocomplete li");
    await list.first().waitFor(WAIT);
    assert.deepEqual((await page.locator(".cm-completionLabel").allTextContents()).sort(), ["kept", "painted", "target"]);
    await list.filter({ hasText: "painted" }).click();
    await page.waitForFunction(() => /1 culled/.test(document.getElementById("figures").textContent), null, WAIT);
    await page.context().close();
  },

  async "hovering tells what a key means"() {
    const page = await open("#pipeline=pipelines/learn/02-resources.json");
    await state(page, "fine");
    await page.locator(".cm-line", { hasText: '"fullscreen"' }).first().locator("span", { hasText: '"fullscreen"' }).hover();
    await page.locator(".cm-lsp-hover-tooltip", { hasText: "fragment shader" }).waitFor(WAIT);
    await page.context().close();
  },

  async "a rename reaches a file that no tab shows, and is undone"() {
    const page = await open("#pipeline=pipelines/learn/06-extends.json");
    await state(page, "fine");
    const before = await content(page);
    await go(page, '"painted"', 3);
    await page.locator(".cm-content").press("F2");
    await page.locator(".cm-lsp-rename-panel input").fill("drawn");
    await page.locator(".cm-lsp-rename-panel input").press("Enter");
    await page.waitForFunction(() => document.querySelector(".cm-content").textContent.includes('"&drawn"'), null, WAIT);
    await state(page, "fine");
    await page.selectOption("#open", "pipelines/learn/02-resources.json");
    await page.waitForFunction(() => document.querySelector(".cm-content").textContent.includes('"drawn": {'), null, WAIT);
    await page.locator(".cm-content").press("Control+z");
    await page.waitForFunction(() => document.querySelector(".cm-content").textContent.includes('"painted": {'), null, WAIT);
    await page.locator("#tabs [role=tab]").first().click();
    await page.locator(".cm-content").press("Control+z");
    await state(page, "fine");
    assert.equal(await content(page), before);
    assert.ok(!(await text(page, "#tabs")).includes("•"), "both files are as they came");
    await page.context().close();
  },
});
