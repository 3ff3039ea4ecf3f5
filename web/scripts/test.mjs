// Drives a browser: `node test.mjs SITE COMMAND`. Pictures are read back and compared with those that the command draws on
// the same driver; diagnostics are compared with the expected ones of tests/broken. Without a browser all is skipped and
// counted; where UMBRAGRAPH_REQUIRE_BROWSER is set, that is a failure.
import { execFile } from "node:child_process";
import { mkdirSync, readFileSync, readdirSync } from "node:fs";
import { join, relative } from "node:path";
import { fileURLToPath } from "node:url";
import { promisify } from "node:util";
import { driver, program, start } from "./browser.mjs";
import { page_works } from "./page.mjs";
import { graph_works } from "./graph.mjs";
import { decode } from "./png.mjs";
import { serve } from "./serve.mjs";
import { times } from "./times.mjs";

const ROOT = fileURLToPath(new URL("../..", import.meta.url));
const SIZE = [320, 180];
/** A pixel differs if a channel is further apart than this, of 255; and so many of a hundred may. */
const LEVELS = 8;
const PERCENT = 1;

const small = { cascade_side: 256, cube_side: 128, atlas_min_side: 256, atlas_max_side: 1024, tile_max_side: 256, tile_min_side: 16 };
const system = (pipeline, parameters, scene) => ({ pipeline: `pipelines/${pipeline}.json`, parameters, scene });
const preset = (name, parameters) => ({ ...system("umbra", parameters, "figure"), preset: name });
const lesson = (name, scene) => ({ pipeline: `pipelines/learn/${name}.json`, parameters: {}, scene });

const PICTURES = [
  system("nebula", { resolution: 256 }, "figure"),
  system("mantis", { resolution: 256 }, "figure"),
  system("caracal", { resolution: 256 }, "figure"),
  system("lore", { resolutions: [256, 256, 128, 128] }, "interior"),
  system("awsm", small, "interior"),
  system("umbra", small, "interior"),
  // The flagship's presets; maps of the larger ones are as small as the others'.
  preset("phone", {}),
  ...["console", "desktop", "workstation"].map((name) => preset(name, small)),
  ...["01-smallest", "04-expressions", "08-subgraph", "09-loops-and-mips", "11-persistent", "16-buffers", "18-mesh", "22-contents"]
    .map((name) => lesson(name)),
  ...["27-ssao", "28-bloom"].map((name) => lesson(name, "figure")),
];

/** All texts below folders of the repository, by path. */
function texts(folders, ends) {
  const below = (folder) => readdirSync(join(ROOT, folder), { withFileTypes: true }).flatMap((entry) => {
    const path = join(folder, entry.name);
    return entry.isDirectory() ? below(path) : ends.some((end) => path.endsWith(end)) ? [path] : [];
  });
  const read = (path) => [relative(".", path), readFileSync(join(ROOT, path), "utf8")];
  return Object.fromEntries(folders.flatMap(below).map(read));
}

/** The documents of tests/broken: each replaces texts of one document by others. */
function broken() {
  const folder = join(ROOT, "tests/broken");
  const read = (name) => readFileSync(join(folder, name), "utf8");
  const cases = read("cases.txt").split(/^== /m).slice(1).map((part) => {
    const [name, ...lines] = part.split("\n");
    let text = read("chain.json");
    for (let at = 0; at < lines.length; at++) {
      if (!lines[at].startsWith("- ")) continue;
      const added = lines[at + 1]?.startsWith("+ ") ? lines[at + 1].slice(2) : "";
      text = text.replace(lines[at].slice(2), () => added);
    }
    return { name, text, expected: read(`expected/${name}.txt`) };
  });
  const own = ["display.wgsl.jinja", "display.axes.json"].map((name) => [name, read(name)]);
  return { cases, files: { ...texts(["tests/broken/parts", "pipelines"], [".json"]), ...Object.fromEntries(own) } };
}

/** The picture that the command draws. */
async function native(command, vulkan, { pipeline, preset, parameters, scene }, out) {
  const chosen = preset ? ["--preset", preset] : [];
  const set = Object.entries(parameters).flatMap(([name, value]) => ["--set", `${name}=${JSON.stringify(value)}`]);
  const of = scene ?? "figure";
  const options = ["--scene", `examples/scenes/${of}.glb`, "--size", SIZE.join("x"), "--fast", "--out", out];
  const env = { ...process.env, VK_DRIVER_FILES: vulkan, VK_ICD_FILENAMES: vulkan };
  await promisify(execFile)(command, ["render", pipeline, ...options, ...chosen, ...set], { cwd: ROOT, env });
  return decode(readFileSync(out)).texels;
}

/** How many of a hundred pixels differ. */
function difference(one, other) {
  let differ = 0;
  for (let at = 0; at < one.length; at += 4) {
    differ += [0, 1, 2, 3].some((channel) => Math.abs(one[at + channel] - other[at + channel]) > LEVELS);
  }
  return one.length === other.length ? (differ * 400) / one.length : 100;
}

async function pictures(page, command, vulkan, folder) {
  const files = texts(["pipelines"], [".json"]);
  const failures = [];
  for (const picture of PICTURES) {
    const { pipeline, preset, parameters, scene } = picture;
    const name = `${pipeline}${preset ? ` (${preset})` : ""}${scene ? ` on ${scene}` : ""}`;
    try {
      const out = join(folder, `${name.replace(/\W+/g, "_")}.png`);
      const values = JSON.stringify({ format: 1, ...(preset && { preset }), parameters });
      const asked = { files, pipeline, values, scene: scene ?? "figure", width: SIZE[0], height: SIZE[1] };
      const drawn = page.evaluate((asked) => window.harness.draw(asked), asked);
      // Both are waited for, so that the browser never draws two.
      const ends = await Promise.allSettled([drawn, native(command, vulkan, picture, out)]);
      const failed = ends.find((end) => end.reason);
      if (failed) throw failed.reason;
      const [base64, expected] = ends.map((end) => end.value);
      const texels = Buffer.concat(base64.split(" ").map((part) => Buffer.from(part, "base64")));
      const percent = difference(texels, expected);
      const fine = percent <= PERCENT;
      console.log(`${fine ? "  " : "! "}${name}: ${percent.toFixed(2)} % of pixels differ`);
      if (!fine) failures.push(name);
    } catch (error) {
      console.log(`! ${name}: ${error.message}`);
      failures.push(name);
    }
  }
  return failures;
}

async function documents(page) {
  const { cases, files } = broken();
  if (cases.length < 100) throw new Error(`only ${cases.length} documents were read`);
  const found = await page.evaluate(
    ([files, texts]) => window.harness.diagnose(files, "chain.json", texts), [files, cases.map((one) => one.text)]);
  const wrong = cases.filter((one, at) => one.expected !== found[at]);
  wrong.forEach((one) => console.log(`! ${one.name}: expected\n${one.expected}\nfound\n${found[cases.indexOf(one)]}`));
  console.log(`diagnostics of ${cases.length - wrong.length} of ${cases.length} broken documents are as expected`);
  return wrong.map((one) => one.name);
}

async function main([site, command]) {
  const browser_program = program();
  const vulkan = browser_program && driver(browser_program);
  if (!vulkan) {
    const why = browser_program ? `${browser_program} has no SwiftShader beside it` : "no browser is installed";
    console.log(`skipped: ${PICTURES.length} pictures and ${broken().cases.length} documents (${why}); ` +
      "install chromium, or name one with UMBRAGRAPH_BROWSER");
    return !process.env.UMBRAGRAPH_REQUIRE_BROWSER;
  }
  const folder = join(site, "../native");
  mkdirSync(folder, { recursive: true });
  const { server, address } = await serve(site);
  const browser = await start(browser_program);
  try {
    console.log(`${browser_program} ${browser.version()} with ${vulkan}`);
    const page = await browser.newPage();
    page.on("console", (message) => message.type() === "error" && console.log(`console: ${message.text()}`));
    await page.goto(`${address}harness.html`);
    await page.waitForFunction(() => window.harness, null, { timeout: 60_000 });
    page.setDefaultTimeout(0);
    const failures = [...(await documents(page)), ...(await pictures(page, command, vulkan, folder))];
    await page.close();
    failures.push(...(await page_works(browser, { address, site, command })));
    failures.push(...(await graph_works(browser, address)));
    await times(browser, address);
    if (failures.length) console.log(`${failures.length} failed: ${failures.join(", ")}`);
    return failures.length === 0;
  } finally {
    await browser.close();
    server.close();
  }
}

process.exitCode = (await main(process.argv.slice(2))) ? 0 : 1;
