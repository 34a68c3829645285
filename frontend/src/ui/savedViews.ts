import { keep, readKept } from "./kept";

/** What an address holds, under a name. */
export interface SavedView {
  name: string;
  /** The query of the address, without its question mark. */
  query: string;
}

export const MAX_VIEWS = 50;
export const MAX_VIEW_NAME = 60;

const keyOf = (page: string) => `dock-gateway-views-${page}`;

/** The views that are kept in this browser for a page, by name. What is not one, or the second of a name, is left out. */
export function readViews(page: string): SavedView[] {
  try {
    const kept: unknown = JSON.parse(readKept(keyOf(page)) ?? "[]");
    return Array.isArray(kept) ? kept.filter(isView).reduce<SavedView[]>(withView, []) : [];
  } catch {
    return [];
  }
}

/** Whether this browser keeps them. */
export function writeViews(page: string, views: readonly SavedView[]): boolean {
  return keep(keyOf(page), JSON.stringify(views));
}

/** With a view more; one of the same name is replaced. */
export function withView(views: readonly SavedView[], view: SavedView): SavedView[] {
  const name = view.name.trim();
  return sorted([...views.filter((each) => each.name !== name), { ...view, name }]);
}

export function withoutView(views: readonly SavedView[], name: string): SavedView[] {
  return views.filter((each) => each.name !== name);
}

/** With another name; another view of that name is replaced. */
export function renamed(views: readonly SavedView[], from: string, to: string): SavedView[] {
  const view = views.find(({ name }) => name === from);
  if (view === undefined || to.trim() === "") return [...views];
  return withView(withoutView(views, from), { ...view, name: to });
}

function sorted(views: SavedView[]): SavedView[] {
  return views.sort((one, other) => one.name.localeCompare(other.name));
}

function isView(value: unknown): value is SavedView {
  const { name, query } = (value ?? {}) as Partial<SavedView>;
  return typeof name === "string" && name.trim() !== "" && typeof query === "string";
}
