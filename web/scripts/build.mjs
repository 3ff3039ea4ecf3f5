// Puts the page together: `node build.mjs OUT`, where OUT/checker and OUT/painter are the libraries. OUT/site is the page.
import { build } from "esbuild";
import { cpSync, existsSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

const ROOT = fileURLToPath(new URL("../..", import.meta.url));
const WEB = join(ROOT, "web");
/** What the parts may weigh, compressed, in bytes. */
const AIMS = { checker: 1.5e6, all: 4e6 };

const [out] = process.argv.slice(2);
const site = join(out, "site");
rmSync(site, { recursive: true, force: true });
mkdirSync(site, { recursive: true });
for (const library of ["checker", "painter"]) cpSync(join(out, library), join(site, library), { recursive: true });
cpSync(join(ROOT, "examples/scenes"), join(site, "scenes"), { recursive: true });
cpSync(join(WEB, "scripts/harness.html"), join(site, "harness.html"));
if (existsSync(join(WEB, "page"))) {
  for (const name of ["index.html", "style.css"]) cpSync(join(WEB, "page", name), join(site, name));
  const sections = JSON.parse(readFileSync(join(WEB, "page/gallery.json"), "utf8"));
  for (const { sheet } of sections.flatMap(({ cards }) => cards)) {
    cpSync(join(ROOT, `examples/gallery/${sheet}.jpg`), join(site, `gallery/${sheet}.jpg`));
  }
  await build({
    entryPoints: ["main.js", "checker.js", "painter.js", "server.js"].map((name) => join(WEB, "page", name)),
    outdir: site, bundle: true, format: "esm", minify: true, target: "es2022", logLevel: "warning",
    external: ["./checker/*", "./painter/*"],
  });
  const pipelines = readdirSync(join(ROOT, "pipelines"), { recursive: true }).filter((name) => name.endsWith(".json"));
  const read = (name) => [`pipelines/${name}`, readFileSync(join(ROOT, "pipelines", name), "utf8")];
  const schema = ["pipeline.schema.json", readFileSync(join(ROOT, "pipeline.schema.json"), "utf8")];
  writeFileSync(join(site, "files.json"), JSON.stringify(Object.fromEntries([...pipelines.sort().map(read), schema])));
}

const weight = (folder) => readdirSync(folder, { withFileTypes: true }).reduce((sum, entry) => {
  const path = join(folder, entry.name);
  return sum + (entry.isDirectory() ? weight(path) : gzipSync(readFileSync(path), { level: 9 }).length);
}, 0);
const shown = (bytes) => `${(bytes / 1e6).toFixed(2)} MB`;
const [checker, painter] = ["checker", "painter"].map((name) => weight(join(site, name)));
const all = weight(site) - weight(join(site, "scenes")) - weight(join(site, "gallery"));
console.log(`compressed: the checker ${shown(checker)} (aim ${shown(AIMS.checker)}), the painter ${shown(painter)}, ` +
  `all without scenes and pictures ${shown(all)} (aim ${shown(AIMS.all)})`);
