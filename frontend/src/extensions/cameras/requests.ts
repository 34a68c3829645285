import { type components, deadline, type Http, settle } from "@dock-gateway/client";

export type Camera = components["schemas"]["CameraInfo"];

/** Every failure is a ClientError. */
export async function listCameras(http: Http, robot: string): Promise<Camera[]> {
  const { cameras = [] } = await settle(
    http.GET("/cameras", { params: { query: { robot } }, signal: deadline() }),
  );
  return cameras;
}
