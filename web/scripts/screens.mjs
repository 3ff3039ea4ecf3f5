// Screenshots for docs/web.md: `node screens.mjs SITE FOLDER` writes WebP files, screens in light or dark.
import { mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { program, start } from "./browser.mjs";
import { WAIT, frames, go, solved, state } from "./hands.mjs";
import { serve } from "./serve.mjs";

const VIEW = { width: 1280, height: 800 };
const QUALITY = 0.72;

const drawn = (page) => page.waitForFunction((count) => document.documentElement.dataset.frames >= count, 8, WAIT);

/** Screens: an address, a scheme of colours, and what is done before it is taken. */
const SCREENS = {
  gallery: ["", "light", (page) => page.locator(".card img").first().waitFor(WAIT)],
  course: ["#step=softness", "dark", async (page) => {
    await page.locator("#find").fill("filter");
    await page.locator("#parameters-filter_radius").fill("7");
    await solved(page, 1);
    await drawn(page);
  }],
  editor: ["#pipeline=pipelines/learn/27-ssao.json&scene=foliage", "light", async (page) => {
    await state(page, "fine");
    await drawn(page);
    await go(page, '"&occlusion_2"', 2);
    for (const _ of "occlusion_2") await page.locator(".cm-content").press("Delete");
    await page.locator(".cm-content").press("Control+Space");
    await page.locator(".cm-tooltip-autocomplete li").first().waitFor(WAIT);
  }],
  project: ["#step=alias", "light", async (page) => {
    await state(page, "fine");
    await drawn(page);
    await page.click("#open-project");
  }],
};

/** A PNG as WebP, by the browser's own encoder. */
const webp = (page, png) => page.evaluate(async ([base64, quality]) => {
  const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${base64}`)).blob());
  const canvas = new OffscreenCanvas(image.width, image.height);
  canvas.getContext("2d").drawImage(image, 0, 0);
  const bytes = new Uint8Array(await (await canvas.convertToBlob({ type: "image/webp", quality })).arrayBuffer());
  return btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""));
}, [png.toString("base64"), QUALITY]);

const [site, folder, ...only] = process.argv.slice(2);
mkdirSync(folder, { recursive: true });
const { server, address } = await serve(site);
const browser = await start(program());
try {
  for (const [name, [fragment, colorScheme, prepare]] of Object.entries(SCREENS)) {
    if (only.length && !only.includes(name)) continue;
    const context = await browser.newContext({ viewport: VIEW, colorScheme });
    const page = await context.newPage();
    await page.goto(address + fragment);
    await prepare(page);
    await page.mouse.move(0, 0);
    const bytes = Buffer.from(await webp(page, await page.screenshot()), "base64");
    writeFileSync(join(folder, `${name}.webp`), bytes);
    console.log(`${name}: ${(bytes.length / 1000).toFixed(0)} kB, ${await frames(page)} frames`);
    await context.close();
  }
} finally {
  await browser.close();
  server.close();
}
