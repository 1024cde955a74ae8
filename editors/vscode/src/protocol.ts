// What `planarc lsp` offers beyond the language server protocol.

import type { Location, Position, TextDocumentIdentifier } from "vscode-languageclient/node";

/** A model: a class of a file; without `class` the only one, or the one like the file. */
export interface Model {
  uri: string;
  class?: string;
}

/** The address of a live page, which only this editor knows. */
export interface Page {
  url: string;
  uri?: string;
  class: string;
}

export interface Part {
  class: string;
  component: string;
}

export interface Checked {
  uri: string;
  ok: boolean;
  classes: { class: string; ok: boolean; states?: number; mobility?: number | null }[];
}

export interface Requests {
  "planarc/livePage": [Model, Page];
  "planarc/closePage": [Model, null];
  "planarc/partAt": [{ textDocument: TextDocumentIdentifier; position: Position }, Part | null];
  "planarc/placeOf": [Model & { component: string }, Location | null];
}

/** The server, as panels need it. */
export interface Server {
  ask<M extends keyof Requests>(method: M, given: Requests[M][0]): Promise<Requests[M][1]>;
}
