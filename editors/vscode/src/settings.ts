// The user's settings, and how planarc is started.

import * as fs from "fs";
import * as os from "os";
import * as path from "path";
import * as vscode from "vscode";

/** What the server is told: see `planarc lsp`. */
export interface Settings {
  libraries: string[];
  inlayHints: boolean;
  panel: boolean;
}

export function settings(scope?: vscode.Uri): Settings {
  const all = vscode.workspace.getConfiguration("planarc", scope);
  return {
    libraries: all.get<string[]>("libraries", []).map((folder) => expanded(folder, scope)),
    inlayHints: all.get("inlayHints", true),
    panel: all.get("panel", true),
  };
}

/** The program and its first arguments. */
export function command(scope?: vscode.Uri): string[] {
  const given = vscode.workspace.getConfiguration("planarc", scope).get<string[]>("command", []);
  if (given.length > 0) return given.map((part, i) => (i === 0 ? program(part, scope) : part));
  return [ownProgram(scope) ?? "planarc"];
}

/** planarc of the workspace's own environment; a workspace that is not trusted runs nothing. */
function ownProgram(scope?: vscode.Uri): string | undefined {
  const root = rootOf(scope);
  if (!vscode.workspace.isTrusted || root === undefined) return undefined;
  const inside = process.platform === "win32" ? ["Scripts", "planarc.exe"] : ["bin", "planarc"];
  const places = [".venv", "venv"].map((folder) => path.join(root, folder, ...inside));
  return places.find((place) => fs.existsSync(place));
}

/** A path with the workspace and the home folder put in; the name of a program stays. */
function program(text: string, scope?: vscode.Uri): string {
  return /[\\/]/.test(text) ? expanded(text, scope) : text;
}

function expanded(text: string, scope?: vscode.Uri): string {
  const root = rootOf(scope) ?? "";
  const home = text === "~" || /^~[\\/]/.test(text) ? os.homedir() + text.slice(1) : text;
  const whole = home.replace(/\$\{workspaceFolder\}/g, root);
  return path.isAbsolute(whole) || root === "" ? whole : path.join(root, whole);
}

function rootOf(scope?: vscode.Uri): string | undefined {
  const own = scope && vscode.workspace.getWorkspaceFolder(scope);
  return (own ?? vscode.workspace.workspaceFolders?.[0])?.uri.fsPath;
}
