// What one does with the graph: connect by drags, move, rename, disable, add, group and delete passes, each as one step of
// undo; and random changes by a seed, after each of which the text parses and has its comments.
import assert from "node:assert/strict";
import { complaints } from "./access.mjs";
import { WAIT } from "./hands.mjs";

const SYSTEMS = ["nebula", "mantis", "caracal", "awsm", "lore", "umbra"];
/** A tenth of the random changes that the library's own test makes. */
const CHANGES = 30;
/** So many resources and versions are tried at a pass. */
const PLACES = 8;

const fine = (page) => page.locator('#state:is([data-state="fine"], [data-state="warning"])').waitFor(WAIT);
const settled = (page) => page.waitForFunction(() => document.querySelector("#graph .canvas svg"), null, WAIT);

/** The text in the editor. */
const text = (page) => page.evaluate(() => {
  const content = document.querySelector(".cm-content");
  return (content.cmTile ?? content.cmView).view.state.doc.toString();
});

/** Waits for the text to be another one than it was. */
async function another(page, before, timeout = 20_000) {
  await page.waitForFunction((before) => {
    const content = document.querySelector(".cm-content");
    return (content.cmTile ?? content.cmView).view.state.doc.toString() !== before;
  }, before, { timeout });
  return await text(page);
}

/** Whether a file becomes another than it was, soon. */
const changed = (page) => page.locator("#tabs", { hasText: "•" }).waitFor({ timeout: 5000 }).then(() => true, () => false);

/** The comments of a document, and what is left of it without them. */
export function parts(text) {
  const comments = [];
  const rest = text.replaceAll(/"(?:[^"\\]|\\.)*"|\/\*[^]*?\*\/|\/\/[^\n]*/g, (found) => {
    if (found.startsWith('"')) return found;
    comments.push(found.split(/\s+/).join(" ").trim());
    return " ";
  });
  return { comments: comments.sort(), value: JSON.parse(rest) };
}

/** Opens a pipeline, with its graph. */
async function open(page, path) {
  await page.selectOption("#pipeline", path);
  await page.waitForFunction((path) => document.querySelector("#tabs [aria-selected=true]")?.textContent.startsWith(path.replace("pipelines/", "")), path, WAIT);
  await page.click("#tab-graph");
  await page.waitForFunction((path) => document.querySelector("#graph").dataset.shows === path, path, WAIT);
  await settled(page);
}

const middle = async (locator) => {
  const { x, y, width, height } = await locator.boundingBox();
  return [x + Math.min(width / 2, 40), y + height / 2];
};

/** Drags from one node to another, and stays there. */
async function drag(page, from, to) {
  await page.mouse.move(...from);
  await page.mouse.down();
  await page.mouse.move(from[0] + 10, from[1] + 8, { steps: 2 });
  await page.mouse.move(...to, { steps: 4 });
}

const node = (page, kind, name) => page.locator(`#graph svg [data-${kind}="${name}"]`);

/** A node in view: Tab and keys bring it there. */
async function reveal(page, kind, name) {
  await page.locator("#graph button", { hasText: /^Fit$/ }).click();
  const found = node(page, kind, name);
  await found.evaluate((one) => {
    const area = document.querySelector("#graph .canvas").getBoundingClientRect();
    const box = one.getBoundingClientRect();
    document.querySelector("#graph .canvas").dispatchEvent(new WheelEvent("wheel", { deltaX: box.left - area.left - 200, deltaY: Math.max(0, box.top - area.top - 150), cancelable: true }));
  });
  return found;
}

const press = (page, name) => page.locator("#graph .tools button", { hasText: name }).click();

/** Undoes until no file is another than it was; the number of steps. */
async function undo(page) {
  const tabs = () => page.locator("#tabs").textContent();
  for (let steps = 0; steps < 60; steps++) {
    if (!(await tabs()).includes("•")) return steps;
    const [shown, now] = [await tabs(), await text(page)];
    await press(page, /^Undo$/);
    await page.waitForFunction(([shown, now]) => {
      const content = document.querySelector(".cm-content");
      return document.querySelector("#tabs").textContent !== shown || (content.cmTile ?? content.cmView).view.state.doc.toString() !== now;
    }, [shown, now], { timeout: 20_000 });
  }
  throw new Error("the texts do not come back");
}

/** Places in view from which a texture or buffer can be dragged: bars, and the last write of each, which is a version. */
const textures = (page) => page.locator("#graph svg [data-resource]:not(.data)").evaluateAll((nodes) => {
  const area = document.querySelector("#graph .canvas").getBoundingClientRect();
  const is_seen = (box) => box.right > area.left + 60 && box.left < area.right - 60 && box.top > area.top && box.bottom < area.bottom;
  const places = nodes.flatMap((one) => {
    const bar = one.querySelector(".bar").getBoundingClientRect();
    const dot = [...one.querySelectorAll("circle.write")].map((dot) => dot.getBoundingClientRect()).filter(is_seen).at(-1);
    const version = dot ? [[dot.left + dot.width / 2, dot.top + dot.height / 2]] : [];
    return is_seen(bar) ? [[Math.max(bar.left, area.left) + 30, bar.top + 5], ...version] : version;
  });
  return places.reverse();
});

/** Drags from a place to a pass, and drops on the first slot that takes it and has something else; whether there is one. */
async function connect(page, from, to) {
  await drag(page, from, to);
  // Something else may lie over the place.
  if (!(await page.locator("#graph .connecting").count())) {
    await page.mouse.up();
    return false;
  }
  await page.locator("#graph .slots h3").waitFor(WAIT);
  const [reference] = (await page.locator("#graph .slots h3").textContent()).split(" ");
  const rows = page.locator("#graph .slots button");
  for (let at = 0; at < (await rows.count()); at++) {
    if ((await rows.nth(at).locator("span").textContent()) === reference) continue;
    await rows.nth(at).hover();
    await page.locator("#graph .slots .marked:is(.fine, .refused)").waitFor(WAIT);
    if (await page.locator("#graph .slots .marked.fine").count()) {
      await page.mouse.up();
      return true;
    }
  }
  await page.keyboard.press("Escape");
  await page.mouse.up();
  return false;
}

const steps = {
  async "a drag connects a resource, and says why another cannot be"(page) {
    await open(page, "pipelines/learn/02-resources.json");
    await fine(page);
    const before = await text(page);
    await drag(page, await middle(node(page, "resource", "painted")), await middle(node(page, "pass", "show")));
    const row = page.locator("#graph .slots button", { hasText: "source" });
    await row.hover();
    await page.locator("#graph .slots .fine").waitFor(WAIT);
    const colour = page.locator("#graph .slots button", { hasText: "color 1" });
    await colour.hover();
    await page.locator("#graph .slots .refused").waitFor(WAIT);
    assert.ok((await colour.locator("small").textContent()).length > 20, "a reason");
    await row.hover();
    await page.mouse.up();
    const after = await another(page, before);
    assert.equal(after, before.replace('"source": "&kept"', '"source": "&painted"'));
    assert.equal(await undo(page), 1, "one step");
    assert.equal(await text(page), before);
  },

  async "a node says what it is, and shows its line"(page) {
    await node(page, "pass", "keep").click();
    const panel = page.locator("#graph .details");
    await panel.locator("h2", { hasText: "keep" }).waitFor(WAIT);
    assert.match(await panel.textContent(), /copy.*kept.*Reads.*painted.*Writes.*kept/s);
    const line = (await text(page)).split("\n").findIndex((one) => one.includes('"keep":')) + 1;
    assert.equal(await page.locator(".cm-activeLineGutter").first().textContent(), String(line));
    await node(page, "resource", "painted").click();
    await panel.locator("h2", { hasText: "painted" }).waitFor(WAIT);
    assert.match(await panel.textContent(), /rgba8unorm 256×256.*256\.0 KiB/s);
  },

  async "a pass is renamed, disabled, moved, added, grouped and deleted"(page) {
    const before = await text(page);
    const panel = page.locator("#graph .details");
    const pick = async (name) => {
      await node(page, "pass", name).click();
      await panel.locator("h2", { hasText: name }).waitFor(WAIT);
    };
    let now = before;
    const made = async (work, holds) => {
      await work();
      now = await another(page, now);
      assert.ok(holds(now), now);
      assert.deepEqual(parts(now).comments, parts(before).comments);
    };
    await pick("keep");
    await made(async () => {
      await panel.locator("input").fill("store");
      await panel.locator("input").press("Enter");
    }, (now) => now.includes('"store": { "copy"'));
    await node(page, "pass", "store").waitFor(WAIT);
    await pick("show");
    await made(() => panel.getByRole("button", { name: "Disable" }).click(), (now) => now.includes('"when": false'));
    await page.locator("#graph .absent button", { hasText: "show" }).click();
    await made(() => panel.getByRole("button", { name: "Enable" }).click(), (now) => !now.includes('"when": false'));
    await node(page, "pass", "show").waitFor(WAIT);
    await made(async () => {
      const [x, y] = await middle(node(page, "pass", "show"));
      const [first] = await middle(node(page, "pass", "paint"));
      await drag(page, [x, y], [first - 60, y]);
      await page.mouse.up();
    }, (now) => now.indexOf('"store"') < now.indexOf('"show"'));
    await made(async () => {
      await press(page, /^Add pass/);
      await page.locator(".palette[open] button", { hasText: /^camera/ }).click();
    }, (now) => now.includes('"camera": { "camera": { "to": "&camera" } }'));
    await node(page, "pass", "camera").waitFor(WAIT);
    await panel.locator("h2", { hasText: "camera" }).waitFor(WAIT);
    await made(() => panel.getByRole("button", { name: "Delete" }).click(), (now) => !now.includes("camera"));
    await pick("paint");
    await made(async () => {
      await press(page, /^Group/);
      await page.locator(".palette[open] input").fill("first");
      await page.locator(".palette[open] button", { hasText: "Group" }).click();
    }, (now) => now.includes('"use": "first"'));
    await node(page, "pass", "first.paint").waitFor(WAIT);
    await fine(page);
    assert.equal(await undo(page), 7, "steps of undo");
    assert.equal(await text(page), before);
  },

  async "keys choose, connect and undo, too"(page) {
    await open(page, "pipelines/learn/02-resources.json");
    const before = await text(page);
    await page.locator("#graph svg [data-pass][tabindex='0'], #graph svg [data-resource][tabindex='0']").first().focus();
    await page.keyboard.press("ArrowRight");
    await page.keyboard.press("Enter");
    const name = await page.locator("#graph svg .picked").getAttribute("data-pass");
    await page.locator("#graph .details h2", { hasText: name }).waitFor(WAIT);
    const slot = page.locator("#graph .details .slot select:enabled").first();
    const other = await slot.evaluate((one) => [...one.options].map((option) => option.value).find((value) => value && value !== one.value));
    await slot.selectOption(other);
    const now = await Promise.race([another(page, before), page.locator("#graph .slot small:not(:empty)").first().waitFor(WAIT).then(() => before)]);
    if (now !== before) {
      await page.locator("#graph .canvas [tabindex='0']").first().focus();
      await page.keyboard.press("Control+z");
      await page.waitForFunction((before) => {
        const content = document.querySelector(".cm-content");
        return (content.cmTile ?? content.cmView).view.state.doc.toString() === before;
      }, before, WAIT);
    }
  },

  async "it is labelled, and has contrast, in light and dark"(page) {
    await open(page, "pipelines/learn/02-resources.json");
    for (const colorScheme of ["dark", "light"]) {
      await page.emulateMedia({ colorScheme });
      assert.deepEqual(await complaints(page), [], `all, ${colorScheme}`);
      await node(page, "pass", "paint").click();
      await page.locator("#graph .details .slot").first().waitFor(WAIT);
      assert.deepEqual(await complaints(page), [], `a pass, ${colorScheme}`);
      await press(page, /^Add pass/);
      assert.deepEqual(await complaints(page), [], `the palette, ${colorScheme}`);
      await page.keyboard.press("Escape");
    }
  },

  async "random changes keep comments, parse, and are undone"(page) {
    let seed = 1;
    const below = (end) => {
      seed = (seed * 48271) % 2147483647;
      return seed % Math.max(1, end);
    };
    const panel = page.locator("#graph .details");
    let made = 0;
    for (const lesson of ["08-subgraph", "25-shared-settings", "03-versions"]) {
      await open(page, `pipelines/learn/${lesson}.json`);
      const before = await text(page);
      let now = before;
      for (let round = 0; round < CHANGES / 3; round++) {
        const names = await page.locator("#graph svg [data-pass]").evaluateAll((all) => all.map((one) => one.dataset.pass));
        if (!names.length) break;
        const name = names[below(names.length)];
        await page.evaluate((name) => document.querySelector(`#graph svg [data-pass="${name}"]`)?.dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", bubbles: true })), name);
        const is_there = await panel.locator("h2", { hasText: name }).waitFor({ timeout: 3000 }).then(() => true, () => false);
        if (!is_there) continue;
        const does = [
          () => panel.getByRole("button", { name: "Disable" }).click(),
          () => panel.getByRole("button", { name: "Delete" }).click(),
          async () => {
            await panel.locator(".rename input").fill(`new_${round}`);
            await panel.locator(".rename input").press("Enter");
          },
          async () => {
            const slots = panel.locator(".slot select:enabled");
            const count = await slots.count();
            if (!count) return;
            const slot = slots.nth(below(count));
            const values = await slot.evaluate((one) => [...one.options].map((option) => option.value).filter((value) => value && value !== one.value));
            if (values.length) await slot.selectOption(values[below(values.length)]);
          },
          async () => {
            await press(page, /^Add pass/);
            const kinds = page.locator(".palette[open] li button");
            await kinds.nth(below(await kinds.count())).click();
          },
          async () => {
            await press(page, /^Group/);
            await page.locator(".palette[open] input").fill(`group_${round}`);
            await page.locator(".palette[open] button", { hasText: "Group" }).click();
            await page.locator(".palette[open] .refused:not([hidden])").waitFor({ timeout: 1000 }).then(() => page.keyboard.press("Escape"), () => {});
          },
        ];
        const at = below(does.length);
        await does[at]();
        const after = await another(page, now, 3000).catch(() => now);
        if (after === now) continue;
        made += 1;
        const [old, is] = [parts(now), parts(after)];
        if (at !== 1) assert.deepEqual(is.comments, old.comments);
        else assert.ok(is.comments.every((one) => old.comments.includes(one)), "no new comments");
        now = after;
      }
      await undo(page);
      assert.equal(await text(page), before);
    }
    assert.ok(made >= CHANGES / 3, `only ${made} changes were made`);
    console.log(`  graph: ${made} random changes were made and undone`);
  },

  async "a resource is added like the chosen one, and deleted again"(page) {
    await open(page, "pipelines/learn/02-resources.json");
    const before = await text(page);
    const names = await page.locator("#graph svg [data-resource]").evaluateAll((nodes) => nodes.map((one) => one.dataset.resource));
    await (await reveal(page, "resource", names[0])).click();
    await press(page, /^Add resource$/);
    const with_it = await another(page, before);
    assert.equal(Object.keys(parts(with_it).value.resources).length, Object.keys(parts(before).value.resources).length + 1);
    await fine(page);
    await page.locator("#graph .details button", { hasText: /^Delete$/ }).click();
    await page.locator("#graph .said", { hasText: "is used by" }).waitFor(WAIT);
    assert.equal(await text(page), with_it);
    assert.equal(await undo(page), 1);
    assert.equal(await text(page), before);
  },

  async "every lesson and system: connected, moved and undone, byte for byte"(page) {
    const all = await page.evaluate(() => [...document.querySelectorAll("#pipeline option")].map((one) => one.value));
    const wanted = all.filter((path) => /^pipelines\/learn\//.test(path) || SYSTEMS.some((name) => path === `pipelines/${name}.json`));
    const without = [];
    for (const path of wanted) {
      await open(page, path);
      const before = await text(page);
      const passes = await page.locator("#graph svg [data-pass]").evaluateAll((nodes) => nodes.map((one) => one.dataset.pass));
      let is_connected = false;
      for (const name of passes.slice(-2).reverse()) {
        // A drag near an edge moves the picture: each begins where things are then.
        for (let at = 0; at < PLACES && !is_connected; at++) {
          const target = await reveal(page, "pass", name);
          const from = (await textures(page))[at];
          if (!from) break;
          is_connected = await connect(page, from, await middle(target));
        }
      }
      if (is_connected) assert.ok(await changed(page), `${path} was connected, and the text is the same`);
      else without.push(path.replace(/^.*\//, ""));
      if (passes.length > 1) {
        await reveal(page, "pass", passes.at(-1));
        const [x, y] = await middle(node(page, "pass", passes.at(-1)));
        await drag(page, [x, y], [x - 130, y]);
        await page.mouse.up();
        await page.waitForTimeout(300);
      }
      await undo(page);
      await page.locator("#tabs [role=tab]").first().click();
      assert.equal(await text(page), before, path);
    }
    console.log(`  graph: ${wanted.length} pipelines, ${wanted.length - without.length} with a new connection; none in ${without.join(", ")}`);
    assert.ok(without.length < wanted.length / 8, `${without.length} of ${wanted.length} were not connected`);
  },
};

/** Goes through the steps whose names contain a text; the names of those that fail. */
export async function graph_works(browser, address, only = "") {
  const failures = [];
  const page = await browser.newPage({ viewport: { width: 1440, height: 1000 } });
  page.on("pageerror", (error) => console.log(`! graph: ${error.message}`));
  // Nothing is drawn meanwhile: in software that takes all processors.
  await page.addInitScript(() => Object.defineProperty(Navigator.prototype, "gpu", { get: () => undefined }));
  await page.goto(`${address}#pipeline=pipelines/learn/02-resources.json`);
  await fine(page);
  for (const [name, step] of Object.entries(steps).filter(([name]) => name.includes(only))) {
    const begin = performance.now();
    try {
      await step(page);
      console.log(`  graph: ${name} (${((performance.now() - begin) / 1000).toFixed(0)} s)`);
    } catch (error) {
      console.log(`! graph: ${name}: ${error.message}`);
      failures.push(`graph: ${name}`);
      await page.mouse.up();
      await page.keyboard.press("Escape");
    }
  }
  await page.close();
  return failures;
}
