// Tasks: commands of planarc on a file, with the problems that they print.

import * as vscode from "vscode";
import { command, settings } from "./settings";

interface Definition extends vscode.TaskDefinition {
  command: string;
  file?: string;
  class?: string;
  arguments?: string[];
}

const OFFERED = ["check", "simulate"];

export class Tasks implements vscode.TaskProvider {
  provideTasks(): vscode.Task[] {
    const document = vscode.window.activeTextEditor?.document;
    if (document?.languageId !== "modelica" || document.uri.scheme !== "file") return [];
    const file = vscode.workspace.asRelativePath(document.uri, false);
    return OFFERED.map((name) => taskOf({ type: "planarc", command: name, file }));
  }

  resolveTask(task: vscode.Task): vscode.Task {
    return taskOf(task.definition as Definition, task.scope);
  }
}

function taskOf(definition: Definition, scope?: vscode.Task["scope"]): vscode.Task {
  const { class: name, file = "${file}", arguments: more = [] } = definition;
  const [program, ...first] = command();
  const given = [...first, definition.command, file, ...(name ? [name] : []), ...more];
  const libraries = definition.command === "fmt" ? [] : libraryArguments();
  const run = new vscode.ProcessExecution(program, [...given, ...libraries]);
  const folder = typeof scope === "object" ? scope : vscode.workspace.workspaceFolders?.[0];
  const title = [definition.command, definition.file, name].filter(Boolean).join(" ");
  const task = new vscode.Task(
    definition, folder ?? vscode.TaskScope.Workspace, title, "planarc", run, "$planarc",
  );
  task.group = definition.command === "check" ? vscode.TaskGroup.Build : undefined;
  return task;
}

function libraryArguments(): string[] {
  return settings().libraries.flatMap((folder) => ["--library", folder]);
}
