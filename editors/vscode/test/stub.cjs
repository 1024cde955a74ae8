// A stand-in for the module `vscode`, which only the editor has: it notes what is asked of it.

const Module = require("module");

class Uri {
  constructor(text) { this.text = text; }
  static parse(text) { return new Uri(text); }
  get fsPath() { return decodeURIComponent(this.text.replace(/^file:\/\//, "")); }
  toString() { return this.text; }
}

class Range {
  constructor(...numbers) { this.numbers = numbers; }
}

function event() {
  const listeners = new Set();
  const add = (listener) => {
    listeners.add(listener);
    return { dispose: () => listeners.delete(listener) };
  };
  return { add, fire: (given) => listeners.forEach((listener) => listener(given)) };
}

const selection = event();
const active = event();
const shown = [];
const panels = [];
const settings = new Map();
const folders = [{ uri: Uri.parse("file:///mechanisms") }];

const vscode = {
  Uri, Range,
  ViewColumn: { One: 1, Beside: -2 },
  env: { asExternalUri: async (uri) => uri },
  window: {
    activeTextEditor: undefined,
    visibleTextEditors: [],
    onDidChangeTextEditorSelection: selection.add,
    onDidChangeActiveTextEditor: active.add,
    showTextDocument: async (uri, options) => shown.push([uri.toString(), options]),
    createWebviewPanel: (kind, title) => {
      const received = event();
      const gone = event();
      const posted = [];
      const panel = {
        kind, title, posted, received, revealed: 0,
        webview: { html: "", options: {}, onDidReceiveMessage: received.add, postMessage: (m) => posted.push(m) },
        onDidDispose: gone.add,
        reveal() { panel.revealed += 1; },
        dispose: () => gone.fire(),
      };
      panels.push(panel);
      return panel;
    },
  },
  workspace: {
    isTrusted: true,
    workspaceFolders: folders,
    getWorkspaceFolder: (uri) => folders.find((f) => uri.toString().startsWith(`${f.uri}/`)),
    getConfiguration: () => ({ get: (name, otherwise) => settings.get(name) ?? otherwise }),
  },
  stub: { selection, active, shown, panels, settings },
};

const load = Module._load;
Module._load = (name, ...rest) => (name === "vscode" ? vscode : load(name, ...rest));
