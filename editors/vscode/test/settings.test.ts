// The settings: where planarc and its libraries are.

import * as assert from "assert/strict";
import * as os from "os";
import { test } from "node:test";
import * as vscode from "vscode";
import { command, settings } from "../src/settings";

const { stub } = vscode as any;

test("libraries are whole paths", () => {
  stub.settings.set("libraries", ["~/modelica", "${workspaceFolder}/lib", "more", "/abs", "~x"]);
  const { libraries } = settings();
  assert.deepEqual(libraries, [`${os.homedir()}/modelica`, "/mechanisms/lib", "/mechanisms/more", "/abs", "/mechanisms/~x"]);
});

test("planarc is the one that is named, else the one on the path", () => {
  assert.deepEqual(command(), ["planarc"]);
  stub.settings.set("command", ["tools/python", "-m", "planarc"]);
  assert.deepEqual(command(), ["/mechanisms/tools/python", "-m", "planarc"]);
  stub.settings.set("command", ["python3", "-m", "planarc"]);
  assert.deepEqual(command(), ["python3", "-m", "planarc"]);
});
