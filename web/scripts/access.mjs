// The page without a network, on small screens, and for people who do not see it: rules of axe-core (WCAG 2.2 A and AA, a
// contrast of 4.5:1 among them), in light and dark.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { WAIT, state, text } from "./hands.mjs";
import { serve } from "./serve.mjs";

const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"];

const SCREENS = ["", "#step=pass", "#pipeline=pipelines/lore.json"];

/** What axe says against the page as it is. */
export async function complaints(page) {
  await page.evaluate(AXE);
  const found = await page.evaluate((values) => window.axe.run(document, { runOnly: { type: "tag", values } }), RULES);
  return found.violations.flatMap(({ id, nodes }) => nodes.map(({ target, failureSummary }) => `${id}: ${target.join(" ")}: ${failureSummary}`));
}

const shown = (page, fragment) => (fragment ? page.locator('#state[data-state]').waitFor(WAIT) : page.locator(".card").first().waitFor(WAIT));

/** `open` makes a page for a fragment of an address. */
export const access = (browser, open, site) => ({
  async "screens are labelled, in order, and have contrast"() {
    for (const scheme of ["light", "dark"]) {
      for (const fragment of SCREENS) {
        const page = await open(fragment);
        await page.emulateMedia({ colorScheme: scheme });
        await shown(page, fragment);
        assert.deepEqual(await complaints(page), [], `${fragment || "gallery"}, ${scheme}`);
        if (fragment) {
          await page.click("#open-project");
          assert.deepEqual(await complaints(page), [], `the dialog, ${scheme}`);
        }
        await page.context().close();
      }
    }
  },

  async "a small screen shows all of it"() {
    for (const fragment of SCREENS) {
      const page = await open(fragment);
      await page.setViewportSize({ width: 360, height: 740 });
      await shown(page, fragment);
      const [wide, room] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
      assert.ok(wide <= room, `${fragment || "gallery"} is ${wide} wide on a screen of ${room}`);
      await page.context().close();
    }
  },

  async "the keyboard opens a picture, and every stop shows that it has the focus"() {
    const page = await open("");
    await page.locator(".card").first().waitFor(WAIT);
    for (let at = 0; at < 40; at++) {
      await page.keyboard.press("Tab");
      const stop = await page.evaluate(() => {
        const one = document.activeElement;
        const { outlineStyle, outlineWidth } = getComputedStyle(one);
        return { name: one.textContent.trim(), card: one.classList.contains("card"), seen: outlineStyle !== "none" && parseFloat(outlineWidth) >= 2 };
      });
      assert.ok(stop.seen, `"${stop.name}" does not show the focus`);
      if (stop.card) break;
    }
    await page.keyboard.press("Enter");
    await state(page, "fine");
    await page.context().close();
  },

  async "without a network it opens again"() {
    const { server, address } = await serve(site);
    const context = await browser.newContext();
    const page = await context.newPage();
    await page.addInitScript(() => Object.defineProperty(Navigator.prototype, "gpu", { get: () => undefined }));
    await page.goto(address);
    await page.evaluate(() => navigator.serviceWorker.ready);
    server.closeAllConnections();
    await new Promise((resolve) => server.close(resolve));
    await page.reload();
    await page.locator(".card").first().click();
    await state(page, "fine");
    assert.match(await text(page, "#figures"), /^\d+ passes/);
    await context.close();
  },
});
