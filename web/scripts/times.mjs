// Times of the page: from a key to diagnostics and to a frame, and to the first frame. They are printed; with UMBRAGRAPH_BLESS
// they go into docs/web.md. No time is a failure: machines differ.
import { readFileSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { WAIT, go, state } from "./hands.mjs";

const DOCUMENT = fileURLToPath(new URL("../../docs/web.md", import.meta.url));
const PIPELINE = "pipelines/umbra.json";
const KEYS = 12;

/** The middle of sorted numbers. */
const median = (numbers) => numbers.toSorted((one, other) => one - other)[Math.floor(numbers.length / 2)];

/** The page without what the device and the browser's creation of pipelines take of a frame. */
const own = (end, { total, recorded, created }) => end - (total - recorded) - created;

const next = (page, name) => page.evaluate((name) => new Promise((resolve) => {
  const seen = performance.getEntriesByName(name).length;
  const look = () => {
    const entry = performance.getEntriesByName(name)[seen];
    if (!entry) return setTimeout(look, 5);
    resolve({ at: entry.startTime, detail: entry.detail });
  };
  look();
}), name);

/** Presses a key in the text; the times from it to the next diagnostics and to the next frame of what they plan. */
async function press(page, key) {
  await page.evaluate(() => {
    performance.clearMarks();
    addEventListener("keydown", (event) => (window.pressed = event.timeStamp), { capture: true, once: true });
  });
  const told = next(page, "diagnostics");
  const drawn = next(page, "planned frame");
  await page.keyboard.press(key);
  const [diagnostics, frame] = [await told, await drawn];
  const begin = await page.evaluate(() => window.pressed);
  return { diagnostics: diagnostics.at - begin, frame: own(frame.at - begin, frame.detail), created: frame.detail.created };
}

/** Measures, prints, and writes the table if it is to be blessed. */
export async function times(browser, address) {
  const page = await browser.newPage({ viewport: { width: 1440, height: 900 } });
  await page.goto(`${address}#pipeline=${PIPELINE}&scene=figure`);
  await page.waitForFunction(() => performance.getEntriesByName("planned frame").length > 0, null, WAIT);
  const first = await page.evaluate(() => {
    const [{ startTime, detail }] = performance.getEntriesByName("planned frame");
    return { at: startTime, detail };
  });
  await state(page, "fine");
  await go(page, '"default": ', 0);
  await page.keyboard.press("Home");
  const pressed = [];
  // A space and its removal: the text is another, and its pipelines are the same.
  for (let at = 0; at < KEYS; at++) pressed.push(await press(page, at % 2 ? "Backspace" : "Space"));
  await page.close();
  const of = (name) => median(pressed.map((one) => one[name]));
  const rows = [
    ["from a key in `umbra.json` to the diagnostics of loading and planning", of("diagnostics"), 50],
    ["from a key to the new frame", of("frame"), 300],
    ["from opening the page to the first frame of `umbra`, all from the network's cache", own(first.at, first.detail), 3000],
  ];
  for (const [what, milliseconds, aim] of rows) console.log(`${what}: ${milliseconds.toFixed(0)} ms (aim ${aim})`);
  console.log(`  of the first frame, ${first.detail.created.toFixed(0)} ms in the creation of pipelines and ` +
    `${(first.detail.total - first.detail.recorded).toFixed(0)} ms on the device are not counted`);
  if (!process.env.UMBRAGRAPH_BLESS) return;
  const table = ["| | ms | aim, at most |", "|---|---|---|", ...rows.map(([what, milliseconds, aim]) => `| ${what} | ${milliseconds.toFixed(0)} | ${aim} |`)].join("\n");
  const text = readFileSync(DOCUMENT, "utf8");
  writeFileSync(DOCUMENT, text.replace(/(<!-- times -->\n)[^]*?(\n<!-- \/times -->)/, (_, before, after) => `${before}${table}${after}`));
}
