#!/bin/sh
# Installs Visual Studio Code, as code-server, below the folder $1. Everything comes from npm; nothing is compiled.
# This version needs Node 20. Stubs replace the three modules that npm's scripts would compile.
set -eu
mkdir -p "$1" && cd "$1"
[ -f package.json ] || npm init -y >/dev/null
npm install --ignore-scripts --no-audit --no-fund code-server@4.99.4 playwright-core @vscode/ripgrep-linux-x64
vscode=$PWD/node_modules/code-server/lib/vscode
(cd "$vscode" && npm install --ignore-scripts --omit=dev --no-audit --no-fund)
(cd "$vscode/extensions" && npm install --ignore-scripts --omit=dev --no-audit --no-fund)
ln -sfn node_modules "$vscode/node_modules.asar"
mkdir -p "$vscode/node_modules/@vscode/ripgrep/bin"
cp node_modules/@vscode/ripgrep-linux-x64/bin/rg "$vscode/node_modules/@vscode/ripgrep/bin/rg"
echo 'module.exports = { hash() {}, verify() {} };' >node_modules/argon2/argon2.js
echo 'exports.start = () => {};' >"$vscode/node_modules/native-watchdog/index.js"
cat >"$vscode/node_modules/@vscode/spdlog/index.js" <<'JS'
// Logs, so that the output panel has text.
const { appendFileSync, mkdirSync } = require("fs");
const { dirname } = require("path");
const logger = (file) => {
  mkdirSync(dirname(file), { recursive: true });
  appendFileSync(file, "");
  let end = "\n";
  const one = { clearFormatters() { end = ""; }, getLevel: () => 0 };
  for (const name of ["setPattern", "setLevel", "flush", "drop"]) one[name] = () => {};
  for (const level of ["trace", "debug", "info", "warn", "error", "critical"]) one[level] = (text) => appendFileSync(file, text + end);
  return one;
};
exports.setFlushOn = exports.setLevel = exports.shutdown = () => {};
exports.createRotatingLogger = exports.createAsyncRotatingLogger = async (name, file) => logger(file);
JS
