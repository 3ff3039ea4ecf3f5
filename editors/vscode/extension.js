// Starts `umbragraph lsp` for the files that are pipelines.
const path = require("path");
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
  const patterns = [...settings.get("files")];
  if (templates) {
    const below = vscode.Uri.file(path.resolve(folder ?? "", templates));
    patterns.push(new vscode.RelativePattern(below, "**/*.{jinja,axes.json}"));
  }
  client = new LanguageClient("umbragraph", "umbragraph", server, {
    documentSelector: patterns.map((pattern) => ({ scheme: "file", pattern })),
  });
  context.subscriptions.push(client);
  return client.start();
};

exports.deactivate = () => client?.stop();
