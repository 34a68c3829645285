import "@mantine/spotlight/styles.css";
import type { LiveGoal } from "@dock-gateway/client";
import { useDebouncedValue } from "@mantine/hooks";
import { createSpotlight, Spotlight } from "@mantine/spotlight";
import { keepPreviousData, useQuery } from "@tanstack/react-query";
import { useEffect, useId, useMemo, useState } from "react";
import { useNavigate } from "react-router";
import { useActions } from "../actions/actions";
import { createGoalsApi } from "../api/goals";
import { useFleet, useFleetLive, useFleetTopic, useNaming } from "../fleet/context";
import { isThere } from "../fleet/words";
import { HEADINGS } from "../help/headings";
import { useOperate } from "../operations/context";
import { useMenu } from "../pages/pages";
import { useStopping } from "../stop/everywhere";
import { find, goalIdOf, type Item } from "./items";
import classes from "./search.module.css";

const [store, spotlight] = createSpotlight();

/** How long to wait for the next letter before goals are asked for (ms). */
const PAUSE_MS = 200;

interface PaletteProps {
  opened: boolean;
  onClose: () => void;
}

/** Finds pages, robots, actions and goals, and commands for robots. Below the header, so that Stop can still be pressed. */
export default function Palette({ opened, onClose }: PaletteProps) {
  const [query, setQuery] = useState("");
  useEffect(() => (opened ? spotlight.open() : spotlight.close()), [opened]);
  return (
    <Spotlight.Root
      store={store}
      query={query}
      onQueryChange={setQuery}
      shortcut={null}
      onSpotlightClose={onClose}
      returnFocus={false}
      zIndex={250}
      yOffset="calc(var(--header-height) + 1rem)"
      overlayProps={{ backgroundOpacity: 0.35, blur: 0 }}
      transitionProps={{ duration: 0 }}
      attributes={{ content: { "aria-label": "Search and commands" } }}
    >
      <Found query={query} />
    </Spotlight.Root>
  );
}

function Found({ query }: { query: string }) {
  const groups = useFound(query);
  const trigger = useTrigger();
  const listId = useId();
  const items = groups.flatMap((group) => group.items);
  const shown = items.map(({ id }) => id).join("\n");
  const selected = useSelected(listId, shown);
  return (
    <>
      <Spotlight.Search
        placeholder="Robot, page, goal id, or a command: dock robot2"
        aria-label="Search and commands"
        role="combobox"
        aria-expanded={items.length > 0}
        aria-controls={listId}
        aria-autocomplete="list"
        aria-activedescendant={selected ?? undefined}
      />
      <Spotlight.ActionsList id={listId} role="listbox" aria-label="Found" className={classes.list ?? ""}>
        {groups.map(({ label, items }) => (
          <Spotlight.ActionsGroup key={label} label={label} role="group" aria-label={label}>
            {items.map((item) => {
              const id = `${listId} ${item.id}`.replaceAll(/\s/g, "-");
              return (
                <Spotlight.Action
                  key={item.id}
                  ref={(button) => {
                    // Spotlight leaves out `id`.
                    if (button !== null) button.id = id;
                  }}
                  role="option"
                  aria-selected={selected === id}
                  label={item.label}
                  {...(item.description === null ? {} : { description: item.description })}
                  onClick={() => trigger(item)}
                />
              );
            })}
          </Spotlight.ActionsGroup>
        ))}
      </Spotlight.ActionsList>
      {items.length === 0 && <Spotlight.Empty role="status">Nothing is called that.</Spotlight.Empty>}
    </>
  );
}

/** The pages of the help first, then their headings. */
const HELP = HEADINGS.toSorted((one, other) => one.level - other.level);

/** What is found for a text, as the gateway tells it now. */
function useFound(query: string) {
  const robots = useFleetTopic("robots");
  const naming = useNaming();
  const live = useFleetLive();
  const actions = useActions().data;
  const goals = useGoals(query);
  const pages = useMenu();
  return useMemo(
    () =>
      find(query, {
        robots: [...robots.values()].filter(isThere),
        groups: naming.groups(),
        actions: actions ?? [],
        goals,
        pages,
        help: HELP,
        live,
      }),
    [query, robots, naming, actions, goals, pages, live],
  );
}

const NONE: readonly LiveGoal[] = [];

/** The goals whose id begins with a text. */
function useGoals(query: string): readonly LiveGoal[] {
  const { http } = useFleet();
  const [paused] = useDebouncedValue(goalIdOf(query), PAUSE_MS);
  const id = goalIdOf(query) === null ? null : paused;
  const { data } = useQuery({
    queryKey: ["goals by id", id],
    queryFn: () => createGoalsApi(http).list({ id: id ?? "" }, null),
    enabled: id !== null,
    retry: false,
    placeholderData: keepPreviousData,
  });
  return id === null ? NONE : (data?.goals ?? NONE);
}

/** The element id of the item that Enter is for; the first one where what is found has changed. */
function useSelected(listId: string, shown: string): string | null {
  const [selected, setSelected] = useState<string | null>(null);
  useEffect(() => {
    const list = document.getElementById(listId);
    const chosen = () => list?.querySelector("[data-selected]") ?? null;
    const first = list?.querySelector("[data-action]");
    if (shown !== "" && chosen() === null && first != null) {
      // As Spotlight itself marks what the arrow keys have reached.
      first.setAttribute("data-selected", "true");
      store.updateState((state) => ({ ...state, selected: 0 }));
    }
    const tell = () => setSelected(chosen()?.id ?? null);
    tell();
    return store.subscribe(tell);
  }, [listId, shown]);
  return selected;
}

function useTrigger(): (item: Item) => void {
  const navigate = useNavigate();
  const operate = useOperate();
  const stop = useStopping();
  return ({ does }) => {
    if ("to" in does) void navigate(does.to);
    else if (does.names === null) void stop(null);
    else operate(does.operation, does.names);
  };
}
