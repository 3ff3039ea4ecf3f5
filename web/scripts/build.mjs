// Puts the page together: `node build.mjs OUT`, where OUT/checker and OUT/painter are the libraries. OUT/site is the page.
import { build } from "esbuild";
import { cpSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { join, relative } from "node:path";
import { fileURLToPath } from "node:url";
import { report } from "./sizes.mjs";

const ROOT = fileURLToPath(new URL("../..", import.meta.url));
const WEB = join(ROOT, "web");

const [out] = process.argv.slice(2);
const site = join(out, "site");
rmSync(site, { recursive: true, force: true });
mkdirSync(site, { recursive: true });
for (const library of ["checker", "painter"]) cpSync(join(out, library), join(site, library), { recursive: true });
cpSync(join(ROOT, "examples/scenes"), join(site, "scenes"), { recursive: true });
cpSync(join(WEB, "scripts/harness.html"), join(site, "harness.html"));
for (const name of ["index.html", "style.css"]) cpSync(join(WEB, "page", name), join(site, name));
cpSync(join(WEB, "page/graph/graph.css"), join(site, "graph.css"));
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

/** All files of a folder below the site, by path, sorted. */
const files_of = (folder) => readdirSync(join(site, folder), { recursive: true, withFileTypes: true })
  .filter((entry) => entry.isFile())
  .map((entry) => relative(site, join(entry.parentPath ?? entry.path, entry.name)).replaceAll("\\", "/")).sort();

// What a service worker keeps at once: all but what a frame needs, and itself.
const kept = files_of("").filter((path) => !/^(painter\/|scenes\/|harness)/.test(path)).map((path) => (path === "index.html" ? "./" : path));
await build({
  entryPoints: [join(WEB, "page/offline_worker.js")], outdir: site, bundle: true, format: "iife", minify: true, target: "es2022",
  logLevel: "warning", define: { KEPT: JSON.stringify(kept) },
});

report(site, files_of(""));
