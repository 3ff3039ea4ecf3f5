// Starts `umbragraph lsp` for the files that are pipelines.
const path = require("path");
const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

// Generated WGSL, in documents that nobody edits: a line leads back to its template by "Go to Definition".
const SCHEME = "umbragraph-wgsl";
const shown = new Map();

const address = (wanted) => vscode.Uri.from({
  scheme: SCHEME,
  path: `/${wanted.pass}${wanted.variant ? ` ${wanted.variant}` : ""}.wgsl`,
  query: JSON.stringify(wanted),
});

const execute = (command, argument) =>
  client.sendRequest("workspace/executeCommand", { command, arguments: [argument] });

async function generate(uri) {
  shown.set(uri.toString(), await execute("umbragraph.wgsl", JSON.parse(uri.query)));
}

// Values, WGSL and diagnostics as one types are those of this configuration.
async function choose({ pipeline }, refresh) {
  try {
    const listed = await execute("umbragraph.configurations", { pipeline });
    const items = listed.map((one) => ({ label: one.label, detail: one.detail, configuration: one.configuration }));
    const picked = await vscode.window.showQuickPick(items, { placeHolder: "Show this configuration", matchOnDetail: true });
    if (!picked) return;
    await execute("umbragraph.configure", { pipeline, configuration: picked.configuration });
    await refresh();
  } catch (error) {
    vscode.window.showErrorMessage(error.message);
  }
}

// The editor's JSON service says what the schema says, and so does the server: each help and each key would be there
// twice. A file that names the schema gets a language of its own, which leaves it to the server.
const SCHEMA = /"\$schema"\s*:\s*"[^"]*pipeline\.schema\.json"/;

function claim(context, patterns) {
  const take = (document) => {
    const isJson = document.languageId === "json" || document.languageId === "jsonc";
    const isOurs = () => patterns.some((pattern) => vscode.languages.match({ scheme: "file", pattern }, document));
    if (isJson && isOurs() && SCHEMA.test(document.getText())) vscode.languages.setTextDocumentLanguage(document, "umbragraph");
  };
  vscode.workspace.textDocuments.forEach(take);
  context.subscriptions.push(vscode.workspace.onDidOpenTextDocument(take));
}

function wgsl(context, patterns) {
  const changed = new vscode.EventEmitter();
  let timer;
  const refresh = () => Promise.all([...shown.keys()].map(async (key) => {
    const uri = vscode.Uri.parse(key);
    // What cannot be generated at the moment stays as it was; what was closed meanwhile stays closed.
    const before = shown.get(key);
    await generate(uri).catch(() => {});
    if (!vscode.workspace.textDocuments.some((document) => document.uri.toString() === key)) shown.delete(key);
    else if (shown.get(key) !== before) changed.fire(uri);
  }));
  const soon = () => {
    if (shown.size === 0) return;
    clearTimeout(timer);
    timer = setTimeout(refresh, 300);
  };
  const watcher = vscode.workspace.createFileSystemWatcher("**/*.{json,jsonc,jinja}");
  context.subscriptions.push(
    changed,
    watcher,
    watcher.onDidChange(soon),
    { dispose: () => clearTimeout(timer) },
    vscode.workspace.registerTextDocumentContentProvider(SCHEME, {
      onDidChange: changed.event,
      provideTextDocumentContent: async (uri) => {
        if (!shown.has(uri.toString())) await generate(uri);
        return shown.get(uri.toString()).text;
      },
    }),
    vscode.languages.registerDefinitionProvider({ scheme: SCHEME }, {
      provideDefinition: (document, position) => {
        const from = shown.get(document.uri.toString())?.lines[position.line];
        return from && client.protocol2CodeConverter.asLocation(from);
      },
    }),
    vscode.commands.registerCommand("umbragraph.showWgsl", async (wanted) => {
      const uri = address(wanted);
      await generate(uri);
      changed.fire(uri);
      const document = await vscode.workspace.openTextDocument(uri);
      await vscode.window.showTextDocument(document, { viewColumn: vscode.ViewColumn.Beside, preview: true });
    }),
    vscode.commands.registerCommand("umbragraph.chooseConfiguration", (asked) => choose(asked, refresh)),
    vscode.workspace.onDidChangeTextDocument(({ document }) => {
      if (patterns.some((pattern) => vscode.languages.match({ scheme: "file", pattern }, document))) soon();
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
  // Copies of the templates that come with the module, to which "Go to Definition" leads.
  patterns.push("**/templates/[0-9]*.[0-9]*.[0-9]*/**/*.jinja");
  client = new LanguageClient("umbragraph", "umbragraph", server, {
    documentSelector: patterns.map((pattern) => ({ scheme: "file", pattern })),
  });
  context.subscriptions.push(client);
  wgsl(context, patterns);
  return client.start().then(() => claim(context, patterns)).catch((error) => {
    const asked = `\`${server.command} lsp\` does not start. Set "umbragraph.command" to the command's path.`;
    vscode.window.showErrorMessage(`${asked} ${error.message}`);
    throw error;
  });
};

exports.deactivate = () => client?.stop();
