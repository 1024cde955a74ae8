// planarc in VS Code: starts `planarc lsp`, shows live pages, offers tasks.

import * as vscode from "vscode";
import { LanguageClient, type LanguageClientOptions } from "vscode-languageclient/node";
import { KIND, Panels } from "./panel";
import type { Checked, Model, Page, Server } from "./protocol";
import { command, settings } from "./settings";
import { Tasks } from "./tasks";

const LANGUAGE = "modelica";

let client: LanguageClient | undefined;

export async function activate(context: vscode.ExtensionContext): Promise<void> {
  const output = vscode.window.createOutputChannel("planarc", { log: true });
  const status = vscode.languages.createLanguageStatusItem("planarc", { language: LANGUAGE });
  status.name = "planarc";
  const server: Server = {
    ask: (method, given) =>
      client?.isRunning() ? client.sendRequest(method, given) : Promise.reject(new Error("no server")),
  };
  const panels = new Panels(server);
  const start = () => begin(output, status, panels);

  context.subscriptions.push(
    output, status, panels,
    vscode.tasks.registerTaskProvider("planarc", new Tasks()),
    vscode.commands.registerCommand("planarc.showOutput", () => output.show()),
    vscode.commands.registerCommand("planarc.explain", explain),
    vscode.commands.registerCommand("planarc.restart", async () => {
      await stop();
      if (await start()) await panels.renew();
    }),
    vscode.window.registerWebviewPanelSerializer(KIND, {
      async deserializeWebviewPanel(panel: vscode.WebviewPanel, model?: Model) {
        const page = model && (await server.ask("planarc/livePage", model).catch(() => undefined));
        if (model && page) await panels.show(page, model.uri, panel);
        else panel.dispose();
      },
    }),
    vscode.workspace.onDidChangeConfiguration(async (event) => {
      if (event.affectsConfiguration("planarc.command")) {
        await vscode.commands.executeCommand("planarc.restart");
      } else if (event.affectsConfiguration("planarc")) {
        const changed = { settings: { planarc: settings() } };
        await client?.sendNotification("workspace/didChangeConfiguration", changed);
      }
    }),
  );
  await start();
}

export async function deactivate(): Promise<void> {
  await stop();
}

async function stop(): Promise<void> {
  const old = client;
  client = undefined;
  await old?.stop().catch(() => undefined);
  await old?.dispose().catch(() => undefined);
}

/** Start the server; false where it cannot be, which the user is told. */
async function begin(
  output: vscode.LogOutputChannel, status: vscode.LanguageStatusItem, panels: Panels,
): Promise<boolean> {
  const [program, ...first] = command();
  const made = new LanguageClient(
    "planarc", "planarc", { command: program, args: [...first, "lsp"] }, options(output),
  );
  made.onNotification("planarc/showPage", (page: Page & { uri: string }) => panels.show(page, page.uri));
  made.onNotification("planarc/checked", (checked: Checked) => tell(status, checked));
  status.busy = true;
  status.text = "planarc is starting";
  status.severity = vscode.LanguageStatusSeverity.Information;
  try {
    await made.start();
    client = made;
    status.text = "planarc";
    return true;
  } catch (problem) {
    await made.dispose().catch(() => undefined);
    status.text = "planarc is not running";
    status.severity = vscode.LanguageStatusSeverity.Error;
    output.error(String(problem));
    void complain(program);
    return false;
  } finally {
    status.busy = false;
  }
}

async function complain(program: string): Promise<void> {
  const settingsButton = "Open Settings";
  const outputButton = "Show Output";
  const chosen = await vscode.window.showErrorMessage(
    `\`${program} lsp\` cannot be started. Install it by \`pip install "planarc[lsp]"\`, or say in the settings where it is.`,
    settingsButton, outputButton,
  );
  if (chosen === settingsButton) {
    await vscode.commands.executeCommand("workbench.action.openSettings", "planarc.command");
  }
  if (chosen === outputButton) await vscode.commands.executeCommand("planarc.showOutput");
}

function options(output: vscode.LogOutputChannel): LanguageClientOptions {
  return {
    documentSelector: [
      { scheme: "file", language: LANGUAGE },
      { scheme: "untitled", language: LANGUAGE },
    ],
    outputChannel: output,
    initializationOptions: settings(),
    middleware: {
      executeCommand: (name, given, next) => execute(name, given, next, output),
      workspace: {
        configuration: async (params, token, next) => {
          const answers = await next(params, token);
          if (!Array.isArray(answers)) return answers;
          return answers.map((answer, i) => {
            const { section, scopeUri } = params.items[i];
            const scope = scopeUri === undefined ? undefined : vscode.Uri.parse(scopeUri);
            return section === "planarc" ? settings(scope) : answer;
          });
        },
      },
    },
  };
}

/** A command of the server; what the command palette leaves out is asked for or looked up. */
async function execute(
  name: string, given: unknown[], next: (name: string, given: unknown[]) => unknown,
  output: vscode.LogOutputChannel,
): Promise<unknown> {
  if (name === "planarc.handbook") return next(name, given[0] ? given : [placeOfCursor() ?? {}]);
  const model = (given[0] as Partial<Model> | vscode.Uri | undefined) ?? {};
  const editor = vscode.window.activeTextEditor?.document.uri.toString();
  const uri = model instanceof vscode.Uri ? model.toString() : (model.uri ?? editor);
  if (uri === undefined) return undefined;
  const named = model instanceof vscode.Uri ? undefined : model.class;
  const answer = await next(name, [named === undefined ? { uri } : { uri, class: named }]);
  const text = (answer as { text?: unknown } | null)?.text;
  if (typeof text === "string") output.info(text);
  return answer;
}

/** The place of the cursor, as the protocol has it. */
function placeOfCursor(): { uri: string; position: { line: number; character: number } } | undefined {
  const editor = vscode.window.activeTextEditor;
  if (editor?.document.languageId !== LANGUAGE) return undefined;
  const { line, character } = editor.selection.active;
  return { uri: editor.document.uri.toString(), position: { line, character } };
}

/** What a code means, beside the text. */
async function explain(): Promise<void> {
  const prompt = "The code of a message, such as F210";
  const code = await vscode.window.showInputBox({ prompt, placeHolder: "F210" });
  if (!code) return;
  const asked = { command: "planarc.handbook", arguments: [{ code: code.trim().toUpperCase() }] };
  const answer = await client?.sendRequest<{ text: string }>("workspace/executeCommand", asked);
  if (!answer) return;
  const document = await vscode.workspace.openTextDocument({ language: "markdown", content: answer.text });
  await vscode.commands.executeCommand("markdown.showPreview", document.uri);
}

function tell(status: vscode.LanguageStatusItem, checked: Checked): void {
  const wrong = checked.classes.filter((c) => !c.ok).map((c) => c.class);
  const told = checked.classes.filter((c) => c.ok && typeof c.mobility === "number");
  status.detail = told.map((c) => `${c.class}: mobility ${c.mobility}`).join(", ");
  status.severity = wrong.length || !checked.ok
    ? vscode.LanguageStatusSeverity.Warning
    : vscode.LanguageStatusSeverity.Information;
}
