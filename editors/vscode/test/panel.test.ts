// The panel by its messages: what it asks of the server, tells the page, and opens in the editor.

import * as assert from "assert/strict";
import { test } from "node:test";
import * as vscode from "vscode";
import { frameOf, Panels, prefixes } from "../src/panel";
import type { Server } from "../src/protocol";

const { stub } = vscode as any;
const FILE = "file:///mechanisms/four_bar.pmo";
const PAGE = { url: "http://127.0.0.1:1234/token/", class: "FourBar" };
const rest = () => new Promise((done) => setTimeout(done, 80));
const range = (line: number) => ({ start: { line, character: 2 }, end: { line, character: 9 } });

function made(answers: Record<string, (given: never) => unknown>) {
  const asked: [string, unknown][] = [];
  const server: Server = {
    ask: async (method, given) => {
      asked.push([method, given]);
      return (answers[method]?.(given as never) ?? null) as never;
    },
  };
  stub.panels.length = 0;
  stub.shown.length = 0;
  return { panels: new Panels(server), asked };
}

function cursor(line: number, languageId = "modelica") {
  const document = { languageId, uri: vscode.Uri.parse(FILE) };
  stub.selection.fire({ textEditor: { document, selection: { active: { line, character: 4 } } } });
}

test("a click goes to the line in the user's file, not in the library", async () => {
  const places: Record<string, unknown> = {
    "coupler.shape": { uri: "file:///lib/FixedTranslation.pmo", range: range(3) },
    coupler: { uri: FILE, range: range(26) },
  };
  const { panels } = made({ "planarc/placeOf": ({ component }: { component: string }) => places[component] });
  await panels.show(PAGE, FILE);
  stub.panels[0].received.fire({ type: "planarc/picked", component: "coupler.shape" });
  await rest();
  assert.equal(stub.shown.length, 1);
  const [uri, options] = stub.shown[0];
  assert.equal(uri, FILE);
  assert.deepEqual(options.selection.numbers, [26, 2, 26, 9]);
  panels.dispose();
});

test("what no file holds goes nowhere, and what only a library holds goes there", async () => {
  const { panels } = made({
    "planarc/placeOf": ({ component }: { component: string }) =>
      component === "a" ? { uri: "file:///lib/A.pmo", range: range(1) } : null,
  });
  await panels.goTo({ uri: FILE, class: "FourBar" }, "b.c");
  assert.equal(stub.shown.length, 0);
  await panels.goTo({ uri: FILE, class: "FourBar" }, "a.b[2].c");
  assert.equal(stub.shown[0][0], "file:///lib/A.pmo");
  panels.dispose();
});

test("the component under the cursor is lit up, the last one only", async () => {
  const { panels, asked } = made({
    "planarc/partAt": ({ position }: { position: { line: number } }) =>
      position.line === 9 ? null : { class: "FourBar", component: `part${position.line}` },
  });
  await panels.show(PAGE, FILE);
  for (const line of [1, 2, 3]) cursor(line);
  await rest();
  assert.equal(asked.filter(([method]) => method === "planarc/partAt").length, 1);
  assert.deepEqual(stub.panels[0].posted, [{ type: "planarc/lit", component: "part3" }]);
  cursor(9);
  await rest();
  cursor(1, "python");
  await rest();
  assert.deepEqual(stub.panels[0].posted.at(-1), { type: "planarc/lit", component: "" });
  // The page asks when it has come: it may be later than the cursor.
  cursor(4);
  await rest();
  stub.panels[0].received.fire({ type: "planarc/loaded" });
  assert.deepEqual(stub.panels[0].posted.slice(-2).map((m: { component: string }) => m.component), ["part4", "part4"]);
  panels.dispose();
});

test("a model has one panel, and its page ends with it", async () => {
  const { panels, asked } = made({});
  await panels.show(PAGE, FILE);
  await panels.show(PAGE, FILE);
  await panels.show({ ...PAGE, class: "Other" }, FILE);
  assert.equal(stub.panels.length, 2);
  assert.equal(stub.panels[0].revealed, 1);
  stub.panels[0].dispose();
  assert.deepEqual(asked.at(-1), ["planarc/closePage", { uri: FILE, class: "FourBar" }]);
  panels.dispose();
});

test("a page of a new server fills the panel that is there", async () => {
  const { panels } = made({ "planarc/livePage": () => ({ ...PAGE, url: "http://127.0.0.1:99/new/" }) });
  await panels.show(PAGE, FILE);
  await panels.renew();
  assert.equal(stub.panels.length, 1);
  assert.match(stub.panels[0].webview.html, /127\.0\.0\.1:99\/new\//);
  panels.dispose();
});

test("the panel's own page lets in planarc's page and nothing else", () => {
  const html = frameOf("http://127.0.0.1:1234/token/", { uri: "file:///a</script><b>", class: "A" });
  assert.match(html, /default-src 'none'; frame-src http:\/\/127\.0\.0\.1:1234;/);
  assert.ok(!html.includes("</script><b>"));
  assert.ok(!html.includes("unsafe"));
});

test("a component is looked for from the inside out", () => {
  assert.deepEqual(prefixes("a.b[1].c"), ["a.b[1].c", "a.b[1]", "a"]);
  assert.deepEqual(prefixes("'x.y'.z"), ["'x.y'.z", "'x.y'"]);
  assert.deepEqual(prefixes(""), []);
});
