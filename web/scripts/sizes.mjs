// Sizes of the page's parts, compressed as a server would, and the digest of all of it. With UMBRAGRAPH_BLESS they go into
// docs/web.md.
import { createHash } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

const DOCUMENT = fileURLToPath(new URL("../../docs/web.md", import.meta.url));

/** Parts, each with the files of it, what it may weigh in MB, and when it is loaded. */
const PARTS = [
  ["page", /^(?!checker|painter|scenes|gallery|harness)/, null, "first"],
  ["`checker`", /^checker\//, 1.5, "first"],
  ["`painter`, with device and scenes", /^painter\//, 4, "with the first frame"],
  ["pictures of the gallery", /^gallery\//, null, "as they come into view"],
  ["scenes", /^scenes\//, null, "one at a time"],
];

/** The digest of files: the same for the same texts, wherever they were built. */
export function digest(site, files) {
  const hash = createHash("sha256");
  for (const path of files) hash.update(path).update("\0").update(createHash("sha256").update(readFileSync(join(site, path))).digest());
  return hash.digest("hex");
}

/** Prints sizes, and writes them into the document if it is to be blessed. */
export function report(site, files) {
  const rows = PARTS.map(([name, pattern, aim, when]) => {
    const bytes = files.filter((path) => pattern.test(path)).reduce((sum, path) => sum + gzipSync(readFileSync(join(site, path)), { level: 9 }).length, 0);
    return [name, (bytes / 1e6).toFixed(2), aim?.toFixed(2) ?? "", when];
  });
  for (const [name, size, aim, when] of rows) console.log(`${name}: ${size} MB compressed${aim && ` (aim ${aim})`}, loaded ${when}`);
  console.log(`${files.length} files, sha256 ${digest(site, files)}`);
  if (!process.env.UMBRAGRAPH_BLESS) return;
  const table = ["| part | MB, compressed | aim, at most | loaded |", "|---|---|---|---|", ...rows.map((row) => `| ${row.join(" | ")} |`)].join("\n");
  const text = readFileSync(DOCUMENT, "utf8");
  writeFileSync(DOCUMENT, text.replace(/(<!-- sizes -->\n)[^]*?(\n<!-- \/sizes -->)/, (_, before, after) => `${before}${table}${after}`));
}
