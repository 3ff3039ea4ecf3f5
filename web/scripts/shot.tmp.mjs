import { program, start } from "/work/wt/browser/web/scripts/browser.mjs";
import { serve } from "/work/wt/browser/web/scripts/serve.mjs";
const [scheme, out, script] = process.argv.slice(2);
const { server, address } = await serve("/work/wt/browser/target/web/site");
const b = await start(program());
const page = await b.newPage({ viewport: { width: 1440, height: 900 }, colorScheme: scheme });
page.on("console", m => console.log("console:", m.text()));
page.on("worker", w => w.on("console", m => console.log("worker:", m.text().slice(0,400)))); page.on("pageerror", e => console.log("pageerror:", e.message));
const t = performance.now();
await page.goto(address);
await page.waitForFunction(() => document.documentElement.dataset.frames > 2, null, { timeout: 90000 }).catch(e => console.log("no frame"));
console.log("frame", (performance.now() - t).toFixed(0), await page.textContent("#state"), await page.getAttribute("#state", "title"), await page.textContent("#time"));
if (script) { await (new Function("page", "return (async () => {" + script + "})()"))(page); }
await page.waitForTimeout(1500);
console.log(await page.textContent("#state"), await page.textContent("#notice"), await page.textContent("#cover"));
await page.screenshot({ path: out });
await b.close(); server.close();
