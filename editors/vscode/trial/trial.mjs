// The packaged extension in Visual Studio Code, driven in Chromium, in about five minutes:
//
//   sh trial/setup.sh FOLDER && npm run package && node trial/trial.mjs FOLDER
//
//   UMBRAGRAPH_COMMAND  the command, as an absolute path
//   UMBRAGRAPH_THEME    the color theme; a dark one by default, "Default Light Modern" is the other
//   UMBRAGRAPH_SHOTS    the folder for a screenshot of each step; `shots` in FOLDER by default
//
// Waits have fixed lengths, so a busy machine can make a step fail.
import { execFileSync, spawn } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";

const editor = resolve(process.argv[2] ?? ".");
const command = process.env.UMBRAGRAPH_COMMAND;
if (!command) throw new Error("UMBRAGRAPH_COMMAND names no command");
const shots = process.env.UMBRAGRAPH_SHOTS ?? join(editor, "shots");
const extension = resolve(import.meta.dirname, "../umbragraph-0.1.0.vsix");
const { chromium } = createRequire(join(editor, "x.js"))("playwright-core");
mkdirSync(shots, { recursive: true });

const home = mkdtempSync(join(tmpdir(), "umbragraph-trial-"));
const demo = join(home, "demo");
execFileSync(command, ["new", demo]);
const put = (name, change) => writeFileSync(join(demo, name), change(readFileSync(join(demo, name), "utf8")));
const line = (name, part) => readFileSync(join(demo, name), "utf8").split("\n").findIndex((one) => one.includes(part)) + 1;
mkdirSync(join(home, "data/User"), { recursive: true });
// `umbragraph.command`: the editor takes PATH from a login shell, not from here.
writeFileSync(join(home, "data/User/settings.json"), JSON.stringify({
  "security.workspace.trust.enabled": false,
  "task.allowAutomaticTasks": "off",
  "workbench.startupEditor": "none",
  "workbench.colorTheme": process.env.UMBRAGRAPH_THEME ?? "Default Dark Modern",
  "umbragraph.command": command,
}));

const port = 8950 + (process.pid % 40);
const environment = { ...process.env, XDG_CONFIG_HOME: home, XDG_DATA_HOME: home, UMBRAGRAPH_CACHE: join(home, "umbragraph") };
const start = (...more) => [join(editor, "node_modules/code-server/out/node/entry.js"),
  "--extensions-dir", join(home, "extensions"), "--user-data-dir", join(home, "data"), ...more];
execFileSync(process.execPath, start("--install-extension", extension), { env: environment, stdio: "ignore" });
const served = spawn(process.execPath, start("--auth", "none", "--bind-addr", `127.0.0.1:${port}`, "--disable-telemetry", "--disable-update-check"),
  { env: environment, stdio: "ignore", detached: true });
const browser = await chromium.launch({ executablePath: "/usr/bin/chromium", args: ["--no-sandbox", "--disable-gpu"] });

let failed = 0;
try {
  const page = await browser.newPage({ viewport: { width: 1500, height: 950 } });
  for (let tries = 0; ; tries++) {
    try { await page.goto(`http://127.0.0.1:${port}/?folder=${demo}`); break; } catch (error) { if (tries > 30) throw error; await page.waitForTimeout(500); }
  }
  await page.waitForSelector(".monaco-workbench .part.editor", { timeout: 60_000 });
  const wait = (time) => page.waitForTimeout(time);
  const key = (name) => page.keyboard.press(name);
  // The palette: a file, ">command" or ":line:column".
  const go = async (text) => {
    await key("F1");
    const input = page.locator(".quick-input-widget input[type=text]").first();
    await input.waitFor({ state: "visible", timeout: 5000 });
    await input.fill(text);
    await wait(700);
    await key("Enter");
    await wait(900);
  };
  // The place of a text in a file, which is opened: its line, and the column of the text, plus some.
  const to = async (name, part, more = 0) => {
    await go(name);
    const number = line(name, part);
    const column = readFileSync(join(demo, name), "utf8").split("\n")[number - 1].indexOf(part) + 1 + more;
    await go(`:${number}:${column}`);
    await wait(700);
  };
  const texts = async (selector) => (await page.locator(selector).allInnerTexts()).map((text) => text.replace(/\s+/g, " ").trim());
  const lenses = async () => (await texts(".codelens-decoration")).filter(Boolean);
  const active = async () => [(await texts(".tab.active")).at(-1), await page.locator("#status\\.editor\\.selection").innerText({ timeout: 3000 })].join(" ");
  const definition = async () => { await key("F12"); await wait(3000); return active(); };
  const hover = async () => { await go(">Show or Focus Hover"); await wait(1500); return (await texts(".monaco-hover:visible")).join(" "); };
  const suggested = async () => { await key("Control+Space"); await wait(2500); return texts(".suggest-widget .monaco-list-row"); };
  const problems = async () => { await go(">Problems: Focus on Problems View"); await wait(1000); const all = await texts(".markers-panel-container .monaco-list-row"); await key("Control+1"); return all; };
  const token = async () => { await go(">Developer: Inspect Editor Tokens and Scopes"); await wait(2000); return (await texts(".token-inspect-widget")).join(" "); };
  const lens = (title, of = 0) => page.locator(".codelens-decoration a", { hasText: title }).nth(of).click({ timeout: 5000 });
  const right = () => page.locator(".editor-instance").nth(1).locator(".view-lines").innerText({ timeout: 5000 });
  const saved = async (name) => { await go(">File: Save All Files"); await wait(1500); return readFileSync(join(demo, name), "utf8"); };

  const step = async (name, run, isRight) => {
    let found;
    let right = false;
    try { found = await run(); right = isRight(found); } catch (error) { found = error.message.split("\n")[0]; }
    if (!right) failed++;
    console.log(`${right ? "ok    " : "WRONG "} ${name}${right ? "" : `: ${JSON.stringify(found)}`}`);
    await page.screenshot({ path: join(shots, `${name.replace(/\W+/g, "-")}.png`) });
    await key("Escape");
    await key("Escape");
  };

  await wait(6000);
  await go("glow.wgsl.jinja");
  await wait(6000);
  await step("a template starts the extension", async () => { await wait(2000); return (await texts(".breadcrumbs-control")).join(" "); }, (path) => /glow\.wgsl\.jinja \S/.test(path));
  await go("demo.json");
  await wait(8000);
  await step("lenses", lenses, (found) => found.includes("WGSL") && found[0] === "Configuration: defaults");
  await step("hover", async () => { await to("demo.json", "=glow_strength", 3); return hover(); }, (text) => text.includes("a parameter, declared at"));
  await step("help of the schema once", async () => { await to("demo.json", '"shader": "glow', 2); return hover(); }, (text) => { const said = text.match(/[A-Z][^.]{15,}\./g) ?? []; return said.length > 0 && new Set(said).size === said.length; });
  await step("a key is proposed once", async () => { await to("demo.json", '"shader": "glow', 1); const all = await suggested(); return all.filter((one) => /^color\b|^bind\b|^axes\b/.test(one)); }, (all) => all.length > 0 && new Set(all.map((one) => one.split(" ")[0])).size === all.length);
  await step("inlay hint", async () => (await texts(".view-line")).join(" "), (text) => /=glow_strength" ?0\.4/.test(text));
  await step("semantic tokens", async () => { await to("demo.json", "=glow_strength", 3); return token(); }, (text) => text.includes("semantic token type function"));
  await step("color of an expression", async () => { await to("demo.json", "=glow_strength", 3); return token(); }, (text) => text.includes("foreground entity.name.function"));
  await step("definition of a resource", async () => { await to("demo.json", '"&across"', 3); return definition(); }, (at) => at === `demo.json Ln ${line("demo.json", '"across": {')}, Col 5`);
  await step("definition of a template", async () => { await to("demo.json", '"glow.wgsl', 3); return definition(); }, (at) => at.startsWith("glow.wgsl.jinja Ln 1"));
  await step("references", async () => { await to("demo.json", '"across": {', 3); await key("Shift+F12"); await wait(3000); return texts(".reference-zone-widget .monaco-list-row"); }, (all) => all.length === 5);
  await key("Escape");
  await step("completion of a resource", async () => { await to("demo.json", '"&across"', 2); return suggested(); }, (all) => all.some((one) => one.startsWith("picture")) && all.some((one) => one.startsWith("target")));
  await step("completion of a key", async () => { await to("demo.json", '"shader": "glow', 1); return suggested(); }, (all) => all.some((one) => one.startsWith("entry_points")));
  await step("quick fix", async () => {
    await go("demo.json");
    await go(`:${line("demo.json", '"glow_across"') + 1}:8`);
    await key("Delete");
    await wait(3000);
    const before = await problems();
    await key("Control+.");
    await wait(2500);
    await key("Enter");
    await wait(2000);
    const text = await saved("demo.json");
    return [before, text.split("\n")[line("demo.json", '"glow_across"')], await problems()];
  }, ([before, after, none]) => before.some((one) => one.startsWith('unknown key "ullscreen" umbragraph UG0102')) && after.includes('"fullscreen"') && none.length === 0);
  await step("rename", async () => {
    await to("demo.json", '"across": {', 3);
    await key("F2");
    await wait(1500);
    await key("Control+a");
    await page.keyboard.type("sideways");
    await key("Enter");
    await wait(3000);
    return await saved("demo.json");
  }, (text) => text.match(/sideways/g)?.length === 5 && !/\bacross\b/.test(text));
  await step("format", async () => {
    await go(`:${line("demo.json", '"sideways": {')}:1`);
    await page.keyboard.type("      ");
    await wait(1000);
    await go(">Format Document");
    await wait(2500);
    const asked = await texts(".monaco-dialog-box");
    await key("Escape");
    return asked.length ? asked : (await saved("demo.json")).split("\n").find((one) => one.includes('"sideways": {'));
  }, (text) => text.startsWith?.('    "sideways"'));

  await step("hover in a template", async () => { await to("shaders/glow.wgsl.jinja", "taps }}", 1); return hover(); }, (text) => text.includes("axis taps: 1 to 8"));
  await step("definition of an axis", async () => { await to("shaders/glow.wgsl.jinja", "taps }}", 1); return definition(); }, (at) => at.startsWith("glow.axes.json Ln 1, Col 13"));
  await step("completion in axes", async () => { await to("shaders/glow.axes.json", '"type"', 1); return suggested(); }, (all) => all.includes("requires"));
  await step("completion of a member", async () => { await to("shaders/glow.wgsl.jinja", "covered.uv +", 8); return suggested(); }, (all) => all.some((one) => one.startsWith("uv")));
  await step("definition in what comes with the module", async () => { await to("shaders/glow.wgsl.jinja", "Covered)", 2); return definition(); }, (at) => at.startsWith("fullscreen.wgsl.jinja Ln 3"));
  await step("hover there", async () => { await go(":11:14"); return hover(); }, (text) => text.includes("Covered"));

  await step("WGSL, and the way back", async () => {
    await to("demo.json", '"glow_across"');
    await wait(1500);
    await lens("WGSL", 1);
    await wait(4000);
    const text = await right();
    await go(":25:10");
    return [text, await definition()];
  }, ([text, at]) => text.includes("tap") && at.startsWith("glow.wgsl.jinja Ln 17,"));
  await step("the way back to what comes with the module", async () => { await go(">Go Back"); await wait(2000); await go(":8:10"); const from = await active(); return [from, await definition()]; },
    ([from, at]) => from.startsWith("glow_across.wgsl") && at.startsWith("fullscreen.wgsl.jinja"));
  await step("WGSL follows the template", async () => {
    await go(">View: Close All Editors");
    await to("demo.json", '"glow_across"');
    await wait(1500);
    await lens("WGSL", 1);
    await wait(3000);
    await key("Control+1");
    put("shaders/glow.wgsl.jinja", (text) => text.replace("vec4<f32>(0.0)", "vec4<f32>(0.25)"));
    await wait(4000);
    return right();
  }, (text) => text.includes("0.25"));
  await step("configuration", async () => {
    await go(">View: Close All Editors");
    await go("demo.json");
    await go(":1:1");
    await wait(2000);
    await lens("Configuration");
    await wait(2000);
    await page.keyboard.type("fxaa");
    await key("Enter");
    await wait(3000);
    return lenses();
  }, (found) => found[0] === "Configuration: fxaa on");
  await step("mistake in a template", async () => { await go("glow.wgsl.jinja"); put("shaders/glow.wgsl.jinja", (text) => text.replace("return sum", "return mistake + sum")); await wait(4000); return problems(); },
    (all) => all.some((one) => /`mistake`.*umbragraph UG0520/.test(one)));
  // Tasks are offered, and not run: a terminal needs a module that npm's scripts would compile.
  await step("tasks", async () => {
    await key("F1");
    const input = page.locator(".quick-input-widget input[type=text]").first();
    await input.fill("task umbragraph");
    await wait(4000);
    return texts(".quick-input-widget .monaco-list-row");
  }, (all) => all.some((one) => one.includes("umbragraph: watch")));
  await step("no server", async () => {
    writeFileSync(join(home, "data/User/settings.json"), JSON.stringify({ "security.workspace.trust.enabled": false, "umbragraph.command": "/nowhere" }));
    await wait(2000);
    await page.reload();
    await wait(12_000);
    return texts(".notification-list-item-message");
  }, (all) => all.some((one) => one.includes("umbragraph.command")));
} finally {
  await browser.close();
  process.kill(-served.pid);
  await new Promise((done) => setTimeout(done, 2000));
  rmSync(home, { recursive: true, force: true, maxRetries: 5 });
}
console.log(failed ? `${failed} wrong` : "all right");
process.exit(failed ? 1 : 0);
