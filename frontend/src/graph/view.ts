import { Address, flag, oneOf, text } from "../ui/address";
import { parseThing, type Thing, thingId } from "./things";

/** What the picture shows besides nodes, as in rqt_graph. */
export const SHOWN = ["nodes", "topics", "all"] as const;

/** Nodes only; nodes and topics; nodes, topics and actions. */
export type Shown = (typeof SHOWN)[number];

export type Form = "picture" | "list";

/** What the page shows of the graph. All of it stands in the page's address. */
export interface GraphView {
  /** Null: as it suits the screen. */
  form: Form | null;
  shown: Shown;
  /** `/` for all of them. */
  namespace: string;
  search: string;
  /** What is not shown unless it is asked for. */
  hidden: boolean;
  services: boolean;
  gateway: boolean;
  selected: Thing | null;
  /** Whether the messages of the selected topic are shown. */
  echo: boolean;
}

export const graphView = new Address<GraphView>({
  form: oneOf("view", ["picture", "list"] as const, null),
  shown: oneOf("show", SHOWN, "all"),
  namespace: {
    read: (parameters) => text("namespace", /^\//).read(parameters) || "/",
    write: (value, parameters) => text("namespace").write(value === "/" ? "" : value, parameters),
  },
  search: text("search"),
  hidden: flag("hidden"),
  services: flag("services"),
  gateway: flag("gateway"),
  selected: {
    read: (parameters) => parseThing(parameters.get("selected")),
    write: (thing, parameters) => thing !== null && parameters.set("selected", thingId(thing)),
  },
  echo: flag("echo"),
});

export type ChangeView = (change: Partial<GraphView>) => void;
