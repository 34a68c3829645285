import { type components, deadline, type Http, settle } from "@dock-gateway/client";

type Schemas = components["schemas"];

/** A robot's map without its cells, as `GET /map` tells. */
export type RobotMap = Schemas["RobotMap"];
/** A map's size, its place in its frame, and its revision. */
export type Grid = Schemas["Grid"];
/** What a laser sees, or a path. */
export type Points = Schemas["Points"];

/** A large map takes a while to be encoded and to arrive. */
const TIMEOUT_MS = 30_000;

/** The colours of a map's cells. */
export interface MapColors {
  free: string;
  occupied: string;
  unknown: string;
}

/** Walls are quieter than robots and docks. */
export const MAP_COLORS: Record<"light" | "dark", MapColors> = {
  light: { free: "ffffff00", occupied: "868e96", unknown: "dee2e6a6" },
  dark: { free: "24242400", occupied: "6c757d", unknown: "101113a6" },
};

/**
 * A robot's map as an image, in these colours (`RRGGBB`, or `RRGGBBAA`). Every failure is a ClientError.
 *
 * @param robot Null for the one that the gateway is configured for.
 */
export async function mapImage(http: Http, robot: string | null, colors: MapColors): Promise<Blob> {
  const params = { query: { ...(robot !== null && { robot }), ...colors } };
  const signal = deadline(TIMEOUT_MS);
  return (await settle(http.GET("/map.png", { params, parseAs: "blob", signal }))) as unknown as Blob;
}
