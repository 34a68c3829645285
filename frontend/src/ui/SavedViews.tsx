import { Anchor, Button, Group, Popover, Stack, Text, TextInput } from "@mantine/core";
import { type FormEvent, useState } from "react";
import { Link } from "react-router";
import { siteKey } from "../api/site";
import { keep, readKept } from "./kept";
import { ReasonButton } from "./ReasonButton";
import classes from "./SavedViews.module.css";

interface SavedViewsProps {
  /** What they are kept under. */
  page: string;
  /** The query of the address now. */
  query: string;
  /** How the button looks. */
  variant?: "default" | "subtle";
}

/** What the page's address holds, under names that are kept in this browser: save, open, rename and delete. */
export function SavedViews({ page, query, variant = "default" }: SavedViewsProps) {
  const [opened, setOpened] = useState(false);
  const [views, setViews] = useState(() => readViews(page));
  const [kept, setKept] = useState(true);
  const change = (next: (views: SavedView[]) => SavedView[]) => {
    const changed = next(readViews(page)); // another tab may have changed them
    setKept(writeViews(page, changed));
    setViews(changed);
  };
  const toggle = (open: boolean) => {
    if (open) setViews(readViews(page));
    setOpened(open);
  };
  return (
    <Popover
      opened={opened}
      onChange={toggle}
      position="bottom-end"
      width="min(22rem, 100vw - 2rem)"
      trapFocus
      withinPortal={false}
      shadow="md"
    >
      <Popover.Target>
        <Button
          variant={variant}
          size="compact-sm"
          {...(variant === "subtle" ? { color: "gray" } : {})}
          aria-haspopup="dialog"
          onClick={() => toggle(!opened)}
        >
          Views
        </Button>
      </Popover.Target>
      <Popover.Dropdown aria-label="Saved views">
        <Stack gap="xs">
          {views.length > 0 && (
            <ul className={classes.list} aria-label="Saved views">
              {views.map((view) => (
                <ViewItem
                  key={view.name}
                  view={view}
                  current={view.query === query}
                  onOpen={() => setOpened(false)}
                  onRename={(name) => change((all) => renamed(all, view.name, name))}
                  onDelete={() => change((all) => withoutView(all, view.name))}
                />
              ))}
            </ul>
          )}
          <NameForm
            label="Name of the view"
            verb="Save view"
            reason={views.length >= MAX_VIEWS ? `There are ${MAX_VIEWS} views. Delete one first.` : null}
            onName={(name) => change((all) => withView(all, { name, query }))}
          />
          {kept ? (
            <Text size="sm" c="dimmed">
              Saves what is set on this page under a name, in this browser only.
            </Text>
          ) : (
            <Text size="sm" role="alert">
              This browser does not keep them: its storage is blocked or full.
            </Text>
          )}
        </Stack>
      </Popover.Dropdown>
    </Popover>
  );
}

interface ViewItemProps {
  view: SavedView;
  current: boolean;
  onOpen: () => void;
  onRename: (name: string) => void;
  onDelete: () => void;
}

function ViewItem({ view: { name, query }, current, onOpen, onRename, onDelete }: ViewItemProps) {
  const [renaming, setRenaming] = useState(false);
  if (renaming) {
    const rename = (to: string) => {
      setRenaming(false);
      onRename(to);
    };
    return (
      <li>
        <NameForm label={`New name of ${name}`} verb="Rename" name={name} reason={null} onName={rename} />
      </li>
    );
  }
  return (
    <li className={classes.item}>
      <Anchor
        component={Link}
        to={{ search: query }}
        size="sm"
        className={classes.name ?? ""}
        aria-current={current || undefined}
        fw={current ? 600 : undefined}
        onClick={onOpen}
      >
        {name}
      </Anchor>
      <Button
        variant="subtle"
        size="compact-xs"
        aria-label={`Rename ${name}`}
        onClick={() => setRenaming(true)}
      >
        Rename
      </Button>
      <Button variant="subtle" size="compact-xs" aria-label={`Delete ${name}`} onClick={onDelete}>
        Delete
      </Button>
    </li>
  );
}

interface NameFormProps {
  label: string;
  verb: string;
  name?: string;
  reason: string | null;
  onName: (name: string) => void;
}

function NameForm({ label, verb, name = "", reason, onName }: NameFormProps) {
  const [text, setText] = useState(name);
  const missing = reason ?? (text.trim() === "" ? "Enter a name first." : null);
  const submit = (event: FormEvent) => {
    event.preventDefault();
    if (missing !== null) return;
    onName(text);
    setText("");
  };
  return (
    <form onSubmit={submit}>
      <Group gap="xs" wrap="nowrap">
        <TextInput
          aria-label={label}
          placeholder="Name"
          size="xs"
          flex={1}
          maxLength={MAX_VIEW_NAME}
          value={text}
          onChange={(event) => setText(event.currentTarget.value)}
          data-autofocus={name !== "" || undefined}
        />
        <ReasonButton type="submit" variant="default" size="xs" reason={missing}>
          {verb}
        </ReasonButton>
      </Group>
    </form>
  );
}

/** What an address holds, under a name. */
interface SavedView {
  name: string;
  /** The query of the address, without its question mark. */
  query: string;
}

const MAX_VIEWS = 50;

const MAX_VIEW_NAME = 60;

const keyOf = (page: string) => siteKey(`dock-gateway-views-${page}`);

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

function withoutView(views: readonly SavedView[], name: string): SavedView[] {
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
