// Starts `umbragraph lsp` for the files that are pipelines.
const path = require("path");
const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

// Generated WGSL, in documents that nobody edits: a line leads back to its template by "Go to Definition".
const SCHEME = "umbragraph-wgsl";
const shown = new Map();

async function generate(wanted) {
  const made = await client.sendRequest("workspace/executeCommand", { command: "umbragraph.wgsl", arguments: [wanted] });
  const uri = vscode.Uri.from({ scheme: SCHEME, path: `/${made.title}`, query: JSON.stringify(wanted) });
  shown.set(uri.toString(), made);
  return uri;
}

function wgsl(context) {
  const changed = new vscode.EventEmitter();
  let timer;
  const refresh = () => Promise.all([...shown.keys()].map(async (uri) => {
    const at = vscode.Uri.parse(uri);
    // What cannot be generated at the moment stays as it was.
    await generate(JSON.parse(at.query)).then(() => changed.fire(at), () => {});
  }));
  context.subscriptions.push(
    changed,
    vscode.workspace.registerTextDocumentContentProvider(SCHEME, {
      onDidChange: changed.event,
      provideTextDocumentContent: async (uri) => {
        if (!shown.has(uri.toString())) await generate(JSON.parse(uri.query));
        return shown.get(uri.toString())?.text ?? "";
      },
    }),
    vscode.languages.registerDefinitionProvider({ scheme: SCHEME }, {
      provideDefinition: (document, position) => {
        const from = shown.get(document.uri.toString())?.lines[position.line];
        return from && client.protocol2CodeConverter.asLocation(from);
      },
    }),
    vscode.commands.registerCommand("umbragraph.showWgsl", async (wanted) => {
      const document = await vscode.workspace.openTextDocument(await generate(wanted));
      await vscode.window.showTextDocument(document, { viewColumn: vscode.ViewColumn.Beside, preview: true });
    }),
    vscode.workspace.onDidChangeTextDocument(({ document }) => {
      if (document.uri.scheme !== "file" || shown.size === 0) return;
      clearTimeout(timer);
      timer = setTimeout(refresh, 300);
    }),
    vscode.workspace.onDidCloseTextDocument(({ uri }) => shown.delete(uri.toString())),
  );
}

exports.activate = (context) => {
  const settings = vscode.workspace.getConfiguration("umbragraph");
  const folder = vscode.workspace.workspaceFolders?.[0]?.uri.fsPath;
  const templates = settings.get("templates");
  const server = {
    command: settings.get("command"),
    args: ["lsp", ...(templates ? ["--templates", templates] : [])],
    options: { cwd: folder },
  };
  const patterns = [...settings.get("files")];
  if (templates) {
    const below = vscode.Uri.file(path.resolve(folder ?? "", templates));
    patterns.push(new vscode.RelativePattern(below, "**/*.{jinja,axes.json}"));
  }
  client = new LanguageClient("umbragraph", "umbragraph", server, {
    documentSelector: patterns.map((pattern) => ({ scheme: "file", pattern })),
  });
  context.subscriptions.push(client);
  wgsl(context);
  return client.start();
};

exports.deactivate = () => client?.stop();
