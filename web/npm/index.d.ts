/** How far a call has come: the stage in words, and the part of it that is done, from 0 to 1, if that is known. */
export type Told = (stage: string, part: number | undefined) => void;
/** Options of `foldpath plan` by their names, with numbers or text as values: `{ fold: 0.5, collision: "off" }`. */
export type Options = Record<string, number | string | boolean | (number | string)[]>;
/** Formats of a path: FOLD, a table of angles, an animation, for controllers, and a drawing of the flat sheet. */
export type Format = "fold" | "traj" | "csv" | "rust" | "glb" | "svg" | "dxf" | "joint-trajectory" | "ros2-control" | "pattern";

/** The JSON of `foldpath plan --json`, which docs/schema/plan.json describes. */
export interface Answer {
  outcome: "planned" | "near_goal" | "partial" | "not_rigidly_foldable" | "goal_not_closed" | "crossing" | "undecided" | "timeout";
  reason: string | null;
  reached: number;
  [key: string]: unknown;
}

/** A change of one option that may turn a no into a yes. */
export interface Suggestion {
  option: string;
  value: string;
  /** The sentence about it: what stands before the option with its value, and what stands after it. */
  sentence: [string, string];
}

export interface Planned {
  answer: Answer;
  suggestions: Suggestion[];
  /** Whether a path was found, as far as it goes. */
  hasPath: boolean;
  /** The page that `foldpath view` writes; without a path it shows the flat sheet and what is in the way. */
  page(): string;
  /** The path as a file, as far as it goes; throws if there is none. `fold` has the bytes that `foldpath plan --keep` writes. */
  file(format: Format): Uint8Array;
  /** Gives the memory back. */
  free(): void;
}

/** Prepares the module, from its own place or from bytes or an address; has to end before any other call. */
export function load(module?: BufferSource | URL | string | Response): Promise<void>;
export function version(): string;
/** Makes a pattern, as the text of a FOLD file: `generate({ family: "miura", rows: 3, cols: 3 })`. */
export function generate(family: { family: string; [parameter: string]: number | string }): string;
/** Lists the families that `generate` makes. A parameter has the names that it may have, or `null` if it is a number. */
export function families(): { name: string; title: string; text: string; parameters: { name: string; text: string; names: string[] | null; default: number | string }[] }[];
/** Draws a pattern as SVG. The name of the file tells its format. */
export function draw(name: string, file: Uint8Array | string, options?: Options): string;
/** Describes a pattern as `foldpath info --json` does. The name of the file tells its format. */
export function info(name: string, file: Uint8Array | string, options?: Options): Record<string, unknown>;
/** Plans a pattern. Works on the calling thread: in a page, call it in a worker. Throws an Error if input is bad. */
export function plan(name: string, file: Uint8Array | string, options?: Options, told?: Told): Planned;
/** Judges a path as `foldpath check --json` does, with its options `bound`, `bend` and `contact`. */
export function check(name: string, file: Uint8Array | string, options?: Options, told?: Told): Record<string, unknown>;
/** Lays a folded shape (OBJ, STL, FOLD) flat; returns the text of a FOLD file. */
export function unfold(name: string, file: Uint8Array): string;
/** Returns the page of a path, as `foldpath view` writes it. */
export function view(name: string, file: Uint8Array): string;
