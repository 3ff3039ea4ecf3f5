// A project: the folder that `umbragraph new` makes, taken home and brought back byte for byte; and what a reload keeps.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { unzipSync } from "fflate";
import { WAIT, replace, state, text } from "./hands.mjs";

async function download(page) {
  await page.click("#open-project");
  const [file] = await Promise.all([page.waitForEvent("download", WAIT), page.click("#project-download")]);
  assert.equal(file.suggestedFilename(), "glowing.zip");
  return readFileSync(await file.path());
}

async function begin(page, kind) {
  await page.click("#open-project");
  await page.selectOption("#project-kind", kind);
  await page.click("#project-begin button");
  await page.waitForFunction(() => document.getElementById("pipeline").value === "glowing.json", null, WAIT);
  await state(page, "fine");
}

/** The files that the command writes, by path. */
function written(command, kind) {
  const folder = mkdtempSync(join(tmpdir(), "umbragraph-"));
  try {
    execFileSync(command, ["new", "glowing", "--kind", kind], { cwd: folder });
    const entries = readdirSync(folder, { recursive: true, withFileTypes: true }).filter((entry) => entry.isFile());
    const paths = entries.map((entry) => join(entry.parentPath ?? entry.path, entry.name));
    return Object.fromEntries(paths.map((path) => [path.slice(folder.length + 1), readFileSync(path, "utf8")]));
  } finally {
    rmSync(folder, { recursive: true });
  }
}

const texts = (zip) => Object.fromEntries(Object.entries(unzipSync(zip)).map(([path, bytes]) => [path, new TextDecoder().decode(bytes)]));

/** Pages are made by `open`, which takes a fragment of an address. */
export const project = (command, open) => ({
  async "a project is what the command makes"() {
    for (const kind of ["post", "shadows", "system"]) {
      const page = await open("#step=pass");
      await begin(page, kind);
      assert.deepEqual(texts(await download(page)), written(command, kind), kind);
      await page.context().close();
    }
  },

  async "a zip comes back as it was"() {
    const page = await open("#step=pass");
    await begin(page, "post");
    await page.locator("#parameters-glow_strength").fill("0.7");
    await replace(page, '"default": 4,', '"default": 6,');
    await page.selectOption("#open", "glow.wgsl.jinja");
    await replace(page, "fn ", "fn  ");
    await state(page, "fine");
    const zip = await download(page);
    await page.context().close();
    assert.match(texts(zip)["glowing/glowing.json"], /"default": 6,/);
    assert.match(texts(zip)["glowing/values.json"], /"glow_strength": 0.7/);

    const other = await open("");
    await other.locator(".card").first().click();
    await other.click("#open-project");
    await other.setInputFiles("#project-open", { name: "glowing.zip", mimeType: "application/zip", buffer: zip });
    await other.waitForFunction(() => document.getElementById("pipeline").value === "glowing.json", null, WAIT);
    await state(other, "fine");
    await other.waitForFunction(() => document.getElementById("parameters-glow_strength")?.value === "0.7", null, WAIT);
    assert.ok(zip.equals(await download(other)), "the second zip differs");
    await other.click("#open-project");
    await other.setInputFiles("#project-open", { name: "no.zip", mimeType: "application/zip", buffer: Buffer.from("no zip") });
    await other.locator("#project-error:not([hidden])").waitFor(WAIT);
    await other.context().close();
  },

  async "the parameter file is a tab, and controls follow it"() {
    const page = await open("#pipeline=pipelines/mantis.json");
    await state(page, "fine");
    await page.locator("#parameters-filter_radius").fill("3");
    await page.selectOption("#open", "values.json");
    await page.waitForFunction(() => document.querySelector(".cm-content").textContent.includes('"filter_radius": 3'), null, WAIT);
    await replace(page, '"filter_radius": 3', '"filter_radius": 99');
    await state(page, "error");
    assert.match(await text(page, "#problems .where"), /^values\.json:\d/);
    await replace(page, '"filter_radius": 99', '"filter_radius": 5');
    await state(page, "fine");
    assert.equal(await page.inputValue("#parameters-filter_radius"), "5");
    await page.locator(".cm-content").press("Control+z");
    await state(page, "error");
    await page.context().close();
  },

  async "a reload keeps what was changed"() {
    const page = await open("#pipeline=pipelines/learn/01-smallest.json");
    await state(page, "fine");
    await replace(page, "smallest", "kept");
    await page.waitForFunction(() => sessionStorage.getItem("umbragraph.changed")?.includes("kept"), null, WAIT);
    await page.reload();
    await state(page, "fine");
    assert.match(await text(page, ".cm-content"), /"kept"/);
    await page.context().close();
  },
});
