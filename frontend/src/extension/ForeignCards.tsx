import { Text } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { useLayoutEffect, useRef, useState } from "react";
import { listExtensions } from "../api/extensions";
import { apiPath, pageSite } from "../api/site";
import { useFleet, useFleetLive } from "../fleet/context";
import { Section } from "../ui/Section";
import { sentence } from "../ui/text";

// What a card may rely on is in docs/write-an-extension.md.

/** For what stays the same until the page is loaded again, whether there was an answer or not. */
const ONCE = { staleTime: Number.POSITIVE_INFINITY, gcTime: Number.POSITIVE_INFINITY, retryOnMount: false };

interface ForeignCardsProps {
  /** The robot's namespace. */
  robot: string;
  /** Imports a module: other than the browser does in tests. */
  load?: (path: string) => Promise<unknown>;
}

/** The cards of extensions that are not built into the dashboard; nothing where the gateway has none. */
export function ForeignCards({ robot, load = importModule }: ForeignCardsProps) {
  const { http } = useFleet();
  const live = useFleetLive();
  const { data } = useQuery({
    queryKey: ["extensions"],
    queryFn: () => listExtensions(http),
    // A page about a site of many runs no scripts of the site, which somebody else may be in charge of.
    enabled: live && pageSite() === null,
    ...ONCE,
  });
  return (data?.extensions ?? []).map(
    ({ name, card }) => card !== null && <ForeignCard key={name} {...{ name, card, robot, load }} />,
  );
}

interface ForeignCardProps extends Required<ForeignCardsProps> {
  name: string;
  card: string;
}

/** One card; nothing until its module is there. */
function ForeignCard({ name, card, robot, load }: ForeignCardProps) {
  const tag = `${name.replaceAll("_", "-")}-card`;
  const path = apiPath(card);
  const { data: defined } = useQuery({
    queryKey: ["card", path],
    queryFn: () =>
      load(path).then(
        () => customElements.get(tag) !== undefined,
        () => false,
      ),
    ...ONCE,
  });
  if (defined === undefined) return null;
  return (
    <Section title={sentence(name.replaceAll("_", " "))}>
      {defined ? <Element name={name} tag={tag} robot={robot} /> : <NotLoaded name={name} />}
    </Section>
  );
}

function NotLoaded({ name }: { name: string }) {
  return (
    <Text size="sm" role="status">
      The card of the extension {name} could not be loaded.
    </Text>
  );
}

/** A custom element. React would set a property of that name instead of the attribute, and only after it is connected. */
function Element({ name, tag, robot }: { name: string; tag: string; robot: string }) {
  const frame = useRef<HTMLDivElement>(null);
  // What the element itself throws is reported on the console: the page goes on.
  const [element] = useState(() => document.createElement(tag));
  useLayoutEffect(() => {
    element.setAttribute("robot", robot);
    if (element.parentNode !== frame.current) frame.current?.append(element);
  }, [element, robot]);
  // Its constructor has failed.
  if (element instanceof HTMLUnknownElement) return <NotLoaded name={name} />;
  return <div ref={frame} />;
}

function importModule(path: string): Promise<unknown> {
  return import(/* @vite-ignore */ path);
}
