import type { Json } from "../../../api/jsonSchema";
import type { BatteryDraft, StepDraft } from "../draft";
import { batteryOf } from "../fromMission";
import { PRIORITY } from "../queue";
import { named, type Stored, sorted, useStored } from "../stored";
import { limitsOf } from "../toRequest";
import { parsed, stepsFrom, stepsOf } from "../written";
import { batteryErrors, stepErrors, type Wrong } from "../wrong";
import { usedIn } from "./parameters";
import { deleteTemplate, listTemplates, putTemplate, type Template, type TemplateBody } from "./requests";

export type NamedTemplate = Template & { name: string };

export const TEMPLATES: Stored<NamedTemplate, TemplateBody> = {
  key: ["mission templates"],
  list: async (http) => sorted((await listTemplates(http)).map(named)),
  put: async (http, id, body, base) => named(await putTemplate(http, id, body, base)),
  remove: deleteTemplate,
};

/** The templates that missions are made of, by name. */
export function useTemplates() {
  return useStored(TEMPLATES);
}

/** A value as it was typed: JSON, or text where it is none; undefined for nothing. */
export function typedValue(text: string): Json | undefined {
  if (text.trim() === "") return undefined;
  const value = parsed(text);
  return value === undefined ? text.trim() : value;
}

/** A value to type: `typedValue` returns the same. */
export function textOf(value: unknown): string {
  if (value === null || value === undefined) return "";
  const isPlain = typeof value === "string" && value.trim() === value && parsed(value) === undefined;
  return isPlain && value !== "" ? value : JSON.stringify(value);
}

/** Steps as a template writes them: texts that begin with a dollar are no parameters. */
export function escaped(value: unknown): unknown {
  if (typeof value === "string") return value.startsWith("$") ? `$${value}` : value;
  if (Array.isArray(value)) return value.map(escaped);
  if (typeof value !== "object" || value === null) return value;
  return Object.fromEntries(Object.entries(value).map(([key, item]) => [key, escaped(item)]));
}

/** The parameters that are places wherever steps use them. */
export function placesIn(steps: unknown): Set<string> {
  const places = new Set<string>();
  const others = new Set<string>();
  const look = (value: unknown, at: string) => {
    if (typeof value === "string" && value.startsWith("$"))
      (at === "place" ? places : others).add(value.slice(1));
    else if (typeof value === "object" && value !== null)
      for (const [key, item] of Object.entries(value)) look(item, key);
  };
  look(steps, "");
  return new Set([...places].filter((name) => !others.has(name)));
}

/** A template as it is typed. */
export interface TemplateDraft {
  name: string;
  priority: number | string;
  /** Null: its missions do not return by themselves. */
  battery: BatteryDraft | null;
  steps: readonly StepDraft[];
  /** Of all parameters that were there, by name. */
  parameters: Record<string, { description: string; initial: string }>;
}

/** What a new template starts from. */
export interface Example extends Partial<Omit<TemplateDraft, "steps">> {
  /** As a template writes them. */
  steps: readonly unknown[];
}

export const EXAMPLE: Example = {
  name: "Fetch",
  steps: [
    { navigate: { place: "$shelf" } },
    { notify: { text: "Load me" } },
    { wait: { person: true } },
    { dock: {} },
    { wait: { battery: "$charge" } },
  ],
  parameters: {
    shelf: { description: "Where to load", initial: "" },
    charge: { description: "0 to 1", initial: "0.8" },
  },
};

/** The fields of an example. @param now In the gateway's time (ms). */
export function exampleDraft(example: Example, now: number): Partial<TemplateDraft> {
  return { ...example, steps: stepsFrom(example.steps, now) };
}

/** @param now In the gateway's time (ms). */
export function draftOf(template: NamedTemplate | null, now: number): TemplateDraft {
  const {
    name = "",
    priority = PRIORITY,
    battery = null,
    steps = [{ dock: {} }],
    parameters = {},
  } = template ?? {};
  const typed = Object.entries(parameters).map(([key, { description, default: initial }]) => [
    key,
    { description: description ?? "", initial: textOf(initial) },
  ]);
  return {
    name,
    priority,
    battery: batteryOf(battery),
    steps: stepsFrom(steps, now),
    parameters: Object.fromEntries(typed) as TemplateDraft["parameters"],
  };
}

/** What is wrong with each field. */
export function errorsOf({ name, priority, battery, steps }: TemplateDraft) {
  const errors: Partial<Record<Exclude<keyof TemplateDraft, "battery">, string>> & { battery?: Wrong[] } = {};
  const wrong = battery === null ? [] : batteryErrors(battery);
  if (wrong.length > 0) errors.battery = wrong;
  if (name.trim() === "") errors.name = "Type a name.";
  if (typeof priority !== "number" || priority < 0 || priority > 100 || !Number.isInteger(priority))
    errors.priority = "A whole number from 0 to 100";
  const trouble = stepsTrouble(steps);
  if (trouble !== null) errors.steps = trouble;
  return errors;
}

/** What is wrong with a list of steps; null for nothing. */
export function stepsTrouble(steps: readonly StepDraft[]): string | null {
  if (steps.length === 0) return "Add a step.";
  // A time to wait for may be in the past here: it is judged when a mission is made.
  return steps.some((step) => stepErrors(step, 0).length > 0) ? "Fix what is marked in the steps." : null;
}

export function bodyOf(draft: TemplateDraft, by: string | null): TemplateBody {
  const steps = stepsOf(draft.steps);
  const parameters = usedIn(steps).map((name) => {
    const { description = "", initial = "" } = draft.parameters[name] ?? {};
    return [name, { description: description.trim() || null, default: typedValue(initial) ?? null }];
  });
  return {
    name: draft.name.trim(),
    priority: Number(draft.priority),
    battery: limitsOf(draft.battery),
    steps,
    parameters: Object.fromEntries(parameters) as TemplateBody["parameters"],
    by,
  };
}

/** The arguments for a template as they were typed, without those that are empty. */
export function argumentsOf(template: Template, typed: Record<string, string>): Record<string, Json> {
  const given = Object.keys(template.parameters).map((name) => [name, typedValue(typed[name] ?? "")]);
  return Object.fromEntries(given.filter(([, value]) => value !== undefined)) as Record<string, Json>;
}

/** The parameters that have no value. */
export function missingIn(template: Template, typed: Record<string, string>): string[] {
  return Object.entries(template.parameters)
    .filter(([name, { default: initial }]) => initial == null && typedValue(typed[name] ?? "") === undefined)
    .map(([name]) => name);
}

/** `shelf, charge (0.8)` */
export function parameterWords({ parameters }: Pick<Template, "parameters">): string {
  const words = Object.entries(parameters).map(([name, { default: initial }]) =>
    initial == null ? name : `${name} (${textOf(initial)})`,
  );
  return words.length === 0 ? "No parameters" : `Parameters: ${words.join(", ")}`;
}
