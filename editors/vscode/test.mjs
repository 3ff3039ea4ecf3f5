// `npm test`: the server under the protocol library that the extension's client is made of, over a pipe as in an editor.
// The command to test is UMBRAGRAPH_COMMAND, or `umbragraph`. trial/trial.mjs tries the extension itself.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import protocol from "vscode-languageserver-protocol/node";

const folder = mkdtempSync(join(tmpdir(), "umbragraph-vscode-"));
const DOCUMENT = `{
  "format": 1, "name": "own",
  "features": { "bright": { "type": "bool", "default": false, "description": "Light colors." } },
  "resources": { "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
  "passes": { "fill": { "fullscreen": { "shader": "own.wgsl.jinja", "color": [{ "to": "&target" }] } } }
}
`;
const AXES = `{ "axes": { "bright": { "type": "bool", "default": false, "description": "Light colors." } } }\n`;
const TEMPLATE = `{% include "lib/fullscreen.wgsl.jinja" %}

@fragment
fn main() -> @location(0) vec4<f32> {
    return vec4<f32>({% if bright %}0.75{% else %}0.25{% endif %});
}
`;
const files = { "own.json": DOCUMENT, "own.axes.json": AXES, "own.wgsl.jinja": TEMPLATE };
const uri = (name) => pathToFileURL(join(folder, name)).href;
for (const [name, text] of Object.entries(files)) writeFileSync(join(folder, name), text);

const server = spawn(process.env.UMBRAGRAPH_COMMAND ?? "umbragraph", ["lsp", "--templates", "."], {
  cwd: folder,
  stdio: ["pipe", "pipe", "inherit"],
});
const client = protocol.createProtocolConnection(
  new protocol.StreamMessageReader(server.stdout),
  new protocol.StreamMessageWriter(server.stdin),
);
const published = new Map();
const waiting = [];
client.onNotification("textDocument/publishDiagnostics", ({ uri, diagnostics }) => {
  published.set(uri, diagnostics);
  for (const check of waiting) check();
});
const refreshed = [];
client.onRequest("workspace/codeLens/refresh", () => void refreshed.push("lens"));
client.onRequest("workspace/inlayHint/refresh", () => void refreshed.push("hint"));
client.onRequest("client/registerCapability", () => null);
client.listen();

// Waits until the diagnostics of a file are as wanted.
const diagnosed = (name, isWanted) => new Promise((resolve, reject) => {
  const late = setTimeout(() => reject(new Error(`${name}: ${JSON.stringify(published.get(uri(name)))}`)), 60_000);
  const check = () => {
    const found = published.get(uri(name)) ?? [];
    if (!isWanted(found)) return;
    clearTimeout(late);
    resolve(found);
  };
  waiting.push(check);
  check();
});
const at = (name, text, more = 0) => {
  const before = files[name].slice(0, files[name].indexOf(text) + more).split("\n");
  const position = { line: before.length - 1, character: before.at(-1).length };
  return { textDocument: { uri: uri(name) }, position };
};
const change = (name, text, version) => {
  files[name] = text;
  client.sendNotification("textDocument/didChange", { textDocument: { uri: uri(name), version }, contentChanges: [{ text }] });
};
const execute = (command, argument) =>
  client.sendRequest("workspace/executeCommand", { command, arguments: [argument] });

try {
  const refresh = { refreshSupport: true };
  const { capabilities } = await client.sendRequest("initialize", {
    processId: process.pid,
    rootUri: null,
    workspaceFolders: [{ uri: pathToFileURL(folder).href, name: "own" }],
    capabilities: {
      workspace: { codeLens: refresh, inlayHint: refresh, didChangeWatchedFiles: { dynamicRegistration: true } },
      textDocument: { hover: { contentFormat: ["markdown"] }, publishDiagnostics: { relatedInformation: true } },
      general: { positionEncodings: ["utf-16"] },
    },
  });
  assert.equal(capabilities.positionEncoding, "utf-16");
  client.sendNotification("initialized", {});
  for (const [name, text] of Object.entries(files)) {
    const languageId = name.endsWith(".jinja") ? "jinja" : "json";
    client.sendNotification("textDocument/didOpen", { textDocument: { uri: uri(name), languageId, version: 1, text } });
  }

  // Completion, hover, definition, outline, formatting.
  const items = await client.sendRequest("textDocument/completion", at("own.json", '"&target"', 2));
  assert(items.some((item) => item.label === "target" && item.textEdit.newText === '"&target"'));
  const hover = await client.sendRequest("textDocument/hover", at("own.wgsl.jinja", "bright", 1));
  assert.match(hover.contents.value, /Light colors/);
  const [axis] = await client.sendRequest("textDocument/definition", at("own.wgsl.jinja", "bright", 1));
  assert.equal(axis.uri, uri("own.axes.json"));
  const outline = await client.sendRequest("textDocument/documentSymbol", at("own.json", "{"));
  assert.deepEqual(outline.map((one) => one.name), ["features", "resources", "passes"]);
  const options = { tabSize: 2, insertSpaces: true };
  const edits = await client.sendRequest("textDocument/formatting", { ...at("own.json", "{"), options });
  assert(Array.isArray(edits));

  // A mistake, its quick fix, and the text after it.
  change("own.json", DOCUMENT.replace('"fullscreen"', '"fulscreen"'), 2);
  const [mistake] = await diagnosed("own.json", (found) => found.length > 0);
  const actions = await client.sendRequest("textDocument/codeAction", {
    textDocument: { uri: uri("own.json") }, range: mistake.range, context: { diagnostics: [mistake] },
  });
  assert.equal(actions[0].edit.changes[uri("own.json")][0].newText.includes("fullscreen"), true);
  change("own.json", DOCUMENT, 3);
  await diagnosed("own.json", (found) => found.length === 0);

  // The configuration chosen by a lens: its WGSL, and the error in its branch.
  const lenses = await client.sendRequest("textDocument/codeLens", { textDocument: { uri: uri("own.wgsl.jinja") } });
  assert.deepEqual(lenses.map((lens) => lens.command.title), ["Configuration of own: defaults", "WGSL of fill in own"]);
  const [{ pipeline }] = lenses[0].command.arguments;
  const listed = await execute("umbragraph.configurations", { pipeline });
  const { configuration } = listed.find((one) => one.label === "bright on");
  await execute("umbragraph.configure", { pipeline, configuration });
  const { text } = await execute("umbragraph.wgsl", lenses[1].command.arguments[0]);
  assert.match(text, /0\.75/);
  change("own.wgsl.jinja", TEMPLATE.replace("0.75", "mistake"), 2);
  await diagnosed("own.wgsl.jinja", (found) => found.some((one) => one.message.includes("mistake")));
  change("own.wgsl.jinja", TEMPLATE, 3);
  await diagnosed("own.wgsl.jinja", (found) => found.length === 0);
  assert(refreshed.includes("lens") && refreshed.includes("hint"));

  // A rename, and nothing wrong after it.
  const renamed = await client.sendRequest("textDocument/rename", { ...at("own.json", '"fill"', 2), newName: "paint" });
  assert.equal(renamed.changes[uri("own.json")].length, 1);

  await client.sendRequest("shutdown");
  client.sendNotification("exit");
  const status = await new Promise((resolve) => server.on("exit", resolve));
  assert.equal(status, 0);
  console.log("the server serves vscode-languageserver-protocol: completion, hover, definition, outline, formatting, fixes, lenses, WGSL, rename");
} finally {
  server.kill();
  rmSync(folder, { recursive: true, force: true });
}
