// The mechanism beside the text: the live page in a panel.
//
// The page is planarc's own and runs in a frame of the panel; the panel's script hands messages
// on, in both directions:
//
//   page -> panel -> here   {type: "planarc/picked", component}   go to its line
//   here -> panel -> page   {type: "planarc/lit", component}      light it up
//
// Edits need no message: the server hands the text to the page, saved or not.

import { randomBytes } from "crypto";
import * as vscode from "vscode";
import type { Location } from "vscode-languageclient/node";
import type { Model, Page, Server } from "./protocol";

export const KIND = "planarc.live";
/** Milliseconds for which the cursor rests before its component is lit up. */
const REST = 40;

export class Panels implements vscode.Disposable {
  private readonly open = new Map<string, Panel>();
  private readonly listeners: vscode.Disposable[];
  private resting: NodeJS.Timeout | undefined;
  private turn = 0;

  constructor(private readonly server: Server) {
    this.listeners = [
      vscode.window.onDidChangeTextEditorSelection((event) => this.rest(event.textEditor)),
      vscode.window.onDidChangeActiveTextEditor((editor) => editor && this.rest(editor)),
    ];
  }

  /** Show a page in its panel, or bring that to the front. */
  async show(page: Page, uri: string, into?: vscode.WebviewPanel): Promise<void> {
    const model = { uri, class: page.class };
    const known = this.open.get(key(model));
    if (known) {
      known.reveal();
      if (known.url === page.url) return;
    }
    const frame = known?.view ?? into ?? Panel.create(page.class);
    const external = await outside(page.url);
    const made = known ?? new Panel(model, frame, (component) => void this.goTo(model, component));
    made.fill(page.url, external);
    if (known) return;
    this.open.set(key(model), made);
    frame.onDidDispose(() => {
      this.open.delete(key(model));
      this.server.ask("planarc/closePage", model).catch(() => undefined);
    });
    const editor = vscode.window.activeTextEditor ?? vscode.window.visibleTextEditors[0];
    if (editor) this.rest(editor);
  }

  /** Ask for all pages again: the server that gave them is gone. */
  async renew(): Promise<void> {
    for (const { model } of [...this.open.values()]) {
      const page = await this.server.ask("planarc/livePage", model).catch(() => undefined);
      if (page) await this.show(page, model.uri);
    }
  }

  private rest(editor: vscode.TextEditor): void {
    if (this.open.size === 0 || editor.document.languageId !== "modelica") return;
    clearTimeout(this.resting);
    this.resting = setTimeout(() => void this.light(editor), REST);
  }

  private async light(editor: vscode.TextEditor): Promise<void> {
    const turn = ++this.turn;
    const { line, character } = editor.selection.active;
    const uri = editor.document.uri.toString();
    const part = await this.server
      .ask("planarc/partAt", { textDocument: { uri }, position: { line, character } })
      .catch(() => null);
    if (turn !== this.turn) return; // the cursor has gone on
    for (const panel of this.open.values()) {
      if (panel.model.class === part?.class) panel.light(part?.component ?? "");
      else if (panel.model.uri === uri) panel.light("");
    }
  }

  /** The line of a component; of a part of a library's component, the line of that. */
  async goTo(model: Model, component: string): Promise<void> {
    let found: Location | null = null;
    for (const name of prefixes(component)) {
      const place = await this.server
        .ask("planarc/placeOf", { ...model, component: name })
        .catch(() => null);
      if (!place) continue;
      found = place;
      if (isOwn(vscode.Uri.parse(place.uri), model.uri)) break;
    }
    if (!found) return;
    const { start, end } = found.range;
    const uri = vscode.Uri.parse(found.uri);
    const shown = vscode.window.visibleTextEditors.find((e) => same(e.document.uri, uri));
    await vscode.window.showTextDocument(uri, {
      viewColumn: shown?.viewColumn ?? vscode.ViewColumn.One,
      selection: new vscode.Range(start.line, start.character, end.line, end.character),
    });
  }

  dispose(): void {
    clearTimeout(this.resting);
    this.listeners.forEach((listener) => listener.dispose());
  }
}

class Panel {
  url = "";
  private lit = "";

  constructor(
    readonly model: Model,
    readonly view: vscode.WebviewPanel,
    picked: (component: string) => void,
  ) {
    view.webview.onDidReceiveMessage((message) => {
      if (message?.type === "planarc/picked") picked(String(message.component));
      if (message?.type === "planarc/loaded") this.light(this.lit);
    });
  }

  static create(name: string): vscode.WebviewPanel {
    const place = { viewColumn: vscode.ViewColumn.Beside, preserveFocus: true };
    return vscode.window.createWebviewPanel(KIND, name, place, OPTIONS);
  }

  /** Show the page; `external` is where the editor's own frame finds it. */
  fill(url: string, external: string): void {
    this.url = url;
    this.view.title = this.model.class?.split(".").pop() ?? "planarc";
    this.view.webview.options = OPTIONS;
    this.view.webview.html = frameOf(external, this.model);
  }

  reveal(): void {
    this.view.reveal(undefined, true);
  }

  light(component: string): void {
    this.lit = component;
    void this.view.webview.postMessage({ type: "planarc/lit", component });
  }
}

const OPTIONS = { enableScripts: true, retainContextWhenHidden: true, localResourceRoots: [] };

/** The panel's own page: a frame, and a script that hands messages on. */
export function frameOf(address: string, model: Model): string {
  const nonce = randomBytes(16).toString("base64");
  const { origin } = new URL(address);
  const data = JSON.stringify({ address, origin, model }).replace(/</g, "\\u003c");
  return `<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; frame-src ${origin}; style-src 'nonce-${nonce}'; script-src 'nonce-${nonce}'">
<style nonce="${nonce}">
html, body { height: 100%; margin: 0; padding: 0; overflow: hidden; }
iframe { display: block; width: 100%; height: 100%; border: 0; }
</style>
</head>
<body>
<iframe title="The moving mechanism" allow="clipboard-write"></iframe>
<script nonce="${nonce}">
const { address, origin, model } = ${data};
const editor = acquireVsCodeApi();
const frame = document.querySelector("iframe");
const isDark = () => document.body.matches(".vscode-dark, .vscode-high-contrast:not(.vscode-high-contrast-light)");
const tell = (message) => frame.contentWindow.postMessage({ type: "planarc/lit", dark: isDark(), ...message }, origin);
editor.setState(model);
addEventListener("message", (event) => {
  const page = event.source === frame.contentWindow;
  if (page && event.origin === origin && event.data?.type === "planarc/picked") editor.postMessage(event.data);
  if (!page && event.data?.type === "planarc/lit") tell(event.data);
});
frame.addEventListener("load", () => editor.postMessage({ type: "planarc/loaded" }));
new MutationObserver(() => tell({})).observe(document.body, { attributeFilter: ["class"] });
frame.src = address;
</script>
</body>
</html>`;
}

/** The address under which the editor's own frame finds a page: its port may be forwarded, and
 * some editors keep of an address no more than that. */
async function outside(address: string): Promise<string> {
  const { origin, pathname } = new URL(address);
  const forwarded = await vscode.env.asExternalUri(vscode.Uri.parse(`${origin}/`, true));
  return forwarded.toString(true).replace(/\/+$/, "") + pathname;
}

/** A component and those that it is in, from the inside out: a.b[1].c, a.b[1], a. */
export function prefixes(component: string): string[] {
  const parts = component.match(/(?:'(?:[^'\\]|\\.)*'|[^.'[]+)(?:\[[^\]]*\])?/g) ?? [];
  return parts.map((_, i) => parts.slice(0, parts.length - i).join("."));
}

function isOwn(uri: vscode.Uri, model: string): boolean {
  return same(uri, vscode.Uri.parse(model)) || vscode.workspace.getWorkspaceFolder(uri) !== undefined;
}

const same = (a: vscode.Uri, b: vscode.Uri): boolean => a.toString() === b.toString();
const key = (model: Model): string => `${model.uri} ${model.class}`;
