"use strict";
const report = JSON.parse(document.getElementById("report").textContent);
const comparison = JSON.parse(document.getElementById("comparison").textContent);
const observed = JSON.parse(document.getElementById("observed").textContent);
// A pass may be named as what every object has.
for (const named of [observed.pictures, observed.buffers, observed.times]) Object.setPrototypeOf(named, null);
const passes = new Map(report.passes.map((pass, column) => [pass.name, { ...pass, column }]));
const resources = new Map(report.resources.map((resource) => [resource.name, resource]));
const svg = document.querySelector("#picture svg");
const details = document.getElementById("details");
const table = document.getElementById("table");
let picked = null;

const bytes = (count) => {
  const units = ["B", "KiB", "MiB", "GiB", "TiB"];
  let unit = 0;
  while (count >= 1024 && unit < 4) { count /= 1024; unit += 1; }
  return unit ? `${count.toFixed(1)} ${units[unit]}` : `${count} B`;
};
// Makes an element; strings become text, so no name can become markup.
const make = (tag, attributes = {}, ...children) => {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (key === "onclick") element.onclick = value; else element.setAttribute(key, value);
  }
  element.append(...children.flat());
  return element;
};
const link = (name) => make("button", { class: "link", onclick: () => pick(name) }, name);
const list = (names) => names.length ? names.flatMap((name, at) => (at ? [", ", link(name)] : [link(name)])) : ["nothing"];
const rows = (head, body) => make("table", {}, make("tr", {}, head.map((cell) => make("th", {}, cell))),
  body.map((cells) => make("tr", {}, cells.map((cell) => make("td", {}, ...(Array.isArray(cell) ? cell : [cell]))))));
const meter = (value, most, kind = "") => {
  const fill = make("i", { class: kind });
  fill.style.width = `${most ? (100 * value) / most : 0}%`;
  return make("div", { class: "meter" }, fill);
};

const milliseconds = (time) => `${time.toFixed(3)} ms`;
const longest = Math.max(0, ...report.passes.flatMap((pass) => observed.times[pass.name] ?? []));
// The picture of a resource as a pass leaves it, or else at the end of the frame.
const pictureOf = (name, pass) => observed.pictures[`${name}@${pass}`] ?? observed.pictures[name];
const picture = (name, pass) => pictureOf(name, pass)
  ? [make("figure", {}, make("img", { src: pictureOf(name, pass), alt: name }), make("figcaption", {}, link(name)))] : [];
// The first rows of a buffer, in the same way.
const buffer = (name, pass) => {
  const rows = observed.buffers[`${name}@${pass}`] ?? observed.buffers[name];
  return rows ? [make("h3", {}, link(name)), make("pre", {}, rows)] : [];
};
const timesOf = (name) => {
  const times = observed.times[name];
  if (!times) return [];
  return [make("h3", {}, "Times"), make("div", {}, `${milliseconds(times[0])} processor`), meter(times[0], longest, "processor"),
    make("div", {}, times[1] ? `${milliseconds(times[1])} GPU` : "nothing measured on the GPU"), meter(times[1], longest)];
};
// Bars of the times and a picture of what it writes, at the box of each pass.
function decorate() {
  const add = (box, kind, attributes) => {
    const element = document.createElementNS("http://www.w3.org/2000/svg", kind);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    box.append(element);
  };
  for (const box of svg.querySelectorAll("g.pass")) {
    const body = box.querySelector("rect.body");
    const [x, y, width, height] = ["x", "y", "width", "height"].map((key) => Number(body.getAttribute(key)));
    const times = observed.times[box.dataset.pass] ?? [];
    times.forEach((time, at) => add(box, "rect", { class: `time ${at ? "gpu" : "processor"}`, x: x + 6, y: y + height - 7 + 3 * at,
      width: longest ? ((width - 12) * time) / longest : 0, height: 3 }));
    const [seen] = passes.get(box.dataset.pass).writes.flatMap((name) => pictureOf(name, box.dataset.pass) ?? []);
    if (seen) add(box, "image", { href: seen, x, y: y + height + 14, width, height: 60 });
  }
}

// The passes and resources that have to do with one name, itself among them.
function related(name) {
  const on = new Set([name]);
  const pass = passes.get(name);
  if (pass) for (const resource of [...pass.reads, ...pass.writes]) on.add(resource);
  const resource = resources.get(name);
  if (resource) for (const column of [...resource.read_in, ...resource.written_in]) on.add(report.passes[column].name);
  return on;
}
function highlight(names) {
  svg.classList.toggle("dim", names !== null);
  for (const element of svg.querySelectorAll("[data-pass], [data-resource], .edge[data-from]")) {
    const own = element.dataset.pass ?? element.dataset.resource;
    const on = names !== null && (own ? names.has(own) : names.has(element.dataset.from) && names.has(element.dataset.to));
    element.classList.toggle("on", on);
    element.classList.toggle("picked", own !== undefined && own === picked);
  }
}
function pick(name) {
  picked = name;
  show("Picture");
  highlight(name === null ? null : related(name));
  if (name !== null) document.body.classList.remove("closed");
  svg.querySelector(".picked")?.scrollIntoView({ block: "nearest", inline: "center" });
  details.replaceChildren(closeButton(), ...(passes.has(name) ? passDetails(passes.get(name)) : resources.has(name) ? resourceDetails(resources.get(name)) : overview()));
}

// The button that closes the panel; selecting anything opens it again.
const closeButton = () => make("button", { class: "close", title: "Close the panel", "aria-label": "Close the panel",
  onclick: () => document.body.classList.add("closed") }, "×");
// The longest time of any pass on the processor (0) or the GPU (1).
const longestOf = (at) => Math.max(0, ...Object.values(observed.times).map((times) => times[at]));
function overview() {
  const memory = report.memory;
  const most = Math.max(memory.without_aliasing, 1);
  const live = report.passes.filter((pass) => pass.live).length;
  return [
    make("h2", {}, "Overview"), make("div", { class: "soft" }, `Passes that run: ${live}, culled: ${report.passes.length - live}. Click a pass or a resource.`),
    make("h3", {}, "Memory"),
    make("div", {}, `${bytes(memory.without_aliasing)} without aliasing`), meter(memory.without_aliasing, most, "red"),
    make("div", {}, `${bytes(memory.created)} created`), meter(memory.created, most),
    make("div", {}, `${bytes(memory.bound)} bound: the sum of what each class has alive at once`), meter(memory.bound, most),
    make("div", {}, `${bytes(memory.peak)} alive at most over all classes`), meter(memory.peak, most),
    ...(memory.orders ? [make("h3", {}, "Order for memory"), make("div", {}, `${bytes(memory.orders[0])} as declared, ${bytes(memory.orders[1])} chosen, no order below ${bytes(memory.orders[2])}`)] : []),
    ...(longest ? [make("h3", {}, "Times"), make("div", {}, `Bars at the foot of the passes; the longest is ${milliseconds(longest)}.`),
      make("div", {}, `processor, at most ${milliseconds(longestOf(0))}`), meter(longestOf(0), longest, "processor"),
      make("div", {}, `GPU, at most ${milliseconds(longestOf(1))}`), meter(longestOf(1), longest)] : []),
    make("h3", {}, "Classes"), rows(["class", "resources", "created", "bytes"], memory.classes.map((one) => [one.description, `${one.resources}`, `${one.created}`, bytes(one.bytes)])),
  ];
}
function passDetails(pass) {
  const { column, ...plain } = pass;
  return [
    make("h2", {}, pass.name), make("div", {}, make("span", { class: "tag" }, pass.kind), make("span", { class: pass.live ? "tag" : "tag off" }, pass.live ? "kept" : "culled"),
      ...(pass.toggle ? [make("span", { class: "tag" }, `toggle ${pass.toggle}`)] : [])),
    make("div", { class: "soft" }, pass.declared),
    make("h3", {}, pass.live ? "Why it is kept" : "Why it is culled"), make("ol", {}, pass.why.map((step) => make("li", {}, step))),
    ...(pass.passthrough ? [make("h3", {}, "In a frame without it"), make("ul", {}, pass.passthrough.map((one) => make("li", {}, `readers see ${one}`)))] : []),
    ...timesOf(pass.name), ...pass.writes.flatMap((name) => [...picture(name, pass.name), ...buffer(name, pass.name)]),
    make("h3", {}, "Reads"), make("div", {}, ...list(pass.reads)), make("h3", {}, "Writes"), make("div", {}, ...list(pass.writes)),
    ...(pass.attachments.length ? [make("h3", {}, "Attachments"), rows(["", "load", "store"], pass.attachments.map((one) =>
      [[link(one.resource), ` ${one.kind}`], one.load, one.store + (one.transient_attachment ? " (never leaves the pass)" : "")]))] : []),
    ...(pass.settings ? [make("h3", {}, "Settings"), rows(["", ""], Object.entries(pass.settings))] : []),
    ...(pass.workgroups ? [make("h3", {}, "Workgroups"), make("div", {}, pass.workgroups.join(" × "))] : []),
    ...(pass.variants.length ? [make("h3", {}, "Shader variants"), make("ul", {}, pass.variants.map((one) => make("li", {}, one)))] : []),
    make("h3", {}, "JSON"), make("pre", {}, JSON.stringify(plain)),
  ];
}
function resourceDetails(resource) {
  const at = (columns) => list([...new Set(columns.map((column) => report.passes[column].name))]);
  return [
    make("h2", {}, resource.name), make("div", {}, make("span", { class: "tag" }, resource.lifetime), make("span", { class: resource.live ? "tag" : "tag off" }, resource.place)),
    make("div", { class: "soft" }, resource.declared),
    ...picture(resource.name), ...buffer(resource.name),
    make("h3", {}, "What it is"), make("div", {}, `${resource.description || resource.kind}${resource.bytes ? ` · ${bytes(resource.bytes)}` : ""}`),
    make("h3", {}, "Shares memory with"), make("div", {}, ...list(resource.shares_with)),
    make("h3", {}, "Written by"), make("div", {}, ...at(resource.written_in)), make("h3", {}, "Read by"), make("div", {}, ...at(resource.read_in)),
    make("h3", {}, "JSON"), make("pre", {}, JSON.stringify(resource)),
  ];
}

const tabs = {
  Picture: null,
  Passes: () => rows(["", "pass", "kind", "reads", "writes", "load / store", "variants"], report.passes.map((pass, at) => [pass.live ? `${at + 1}` : "culled", [link(pass.name)], pass.kind,
    list(pass.reads), list(pass.writes), pass.attachments.map((one) => `${one.resource}: ${one.load} / ${one.store}`).join(", "), `${pass.variants.length}`])),
  Resources: () => rows(["resource", "lifetime", "what", "bytes", "place", "shares with"], report.resources.map((one) => [[link(one.name)], one.lifetime, one.description, bytes(one.bytes), one.place, list(one.shares_with)])),
  ...(comparison ? { Comparison: () => make("ul", {}, (comparison.length ? comparison : ["the plans are the same"]).map((line) => make("li", {}, line))) } : {}),
};
function show(name) {
  for (const button of document.querySelectorAll("#tabs button")) button.setAttribute("aria-selected", String(button.textContent === name));
  document.getElementById("picture").hidden = name !== "Picture";
  table.hidden = name === "Picture";
  if (tabs[name]) table.replaceChildren(tabs[name]());
}
for (const name of Object.keys(tabs)) document.getElementById("tabs").append(make("button", { onclick: () => show(name) }, name));

for (const element of svg.querySelectorAll("[data-pass], [data-resource]")) {
  const name = element.dataset.pass ?? element.dataset.resource;
  element.addEventListener("mouseenter", () => { if (picked === null) highlight(related(name)); });
  element.addEventListener("mouseleave", () => { if (picked === null) highlight(null); });
  element.addEventListener("click", (event) => { event.stopPropagation(); pick(name); });
  element.addEventListener("keydown", (event) => { if (event.key === "Enter") pick(name); });
}
svg.addEventListener("click", () => pick(null));
const search = document.getElementById("search");
search.addEventListener("input", () => {
  const wanted = search.value.trim().toLowerCase();
  const names = [...passes.keys(), ...resources.keys()];
  picked = null;
  highlight(wanted ? new Set(names.filter((name) => name.toLowerCase().includes(wanted))) : null);
});
search.addEventListener("keydown", (event) => {
  const first = [...passes.keys(), ...resources.keys()].find((name) => name.toLowerCase().includes(search.value.trim().toLowerCase()));
  if (event.key === "Enter" && first) pick(first);
  if (event.key === "Escape") { search.value = ""; pick(null); }
});
document.addEventListener("keydown", (event) => { if (event.key === "/" && event.target !== search) { event.preventDefault(); search.focus(); } });
decorate();
pick(null);
// A link to a name opens with it: page.html#pass
if (location.hash) pick(decodeURIComponent(location.hash.slice(1)));
