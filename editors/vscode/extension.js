// Starts `umbragraph lsp` for the files that are pipelines.
const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

exports.activate = (context) => {
  const settings = vscode.workspace.getConfiguration("umbragraph");
  const folder = vscode.workspace.workspaceFolders?.[0]?.uri.fsPath;
  const templates = settings.get("templates");
  const server = {
    command: settings.get("command"),
    args: ["lsp", ...(templates ? ["--templates", templates] : [])],
    options: { cwd: folder },
  };
  const patterns = [...settings.get("files"), ...(templates ? [`**/${templates}/**/*.{jinja,axes.json}`] : [])];
  client = new LanguageClient("umbragraph", "umbragraph", server, {
    documentSelector: patterns.map((pattern) => ({ scheme: "file", pattern })),
    synchronize: { fileEvents: patterns.map((pattern) => vscode.workspace.createFileSystemWatcher(pattern)) },
  });
  context.subscriptions.push(client);
  return client.start();
};

exports.deactivate = () => client?.stop();
