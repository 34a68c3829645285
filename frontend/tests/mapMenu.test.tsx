import { act, screen, waitFor, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { describe, expect, it, vi } from "vitest";
import MapMenu, { poseGoal } from "../src/scene/MapMenu";
import type { Pick } from "../src/scene/SceneCanvas";
import { ServicesProvider } from "../src/store/context";
import type { RobotLayer } from "../src/store/layers";
import { emptyScene, simulator } from "./events";
import { fakeGateway, renderWithin, robotServices } from "./page";

const QUARTER = Math.PI / 2;

/** What a layer says of where its ground is: the map that odometry begins at (2, 3) of, at (1, 0) in the frame that is drawn. */
const LAYER: RobotLayer = {
  onEvent: () => {},
  subscribe: () => () => {},
  frameIn: () => null,
  groundIn: () => ({ frame: "map", pose: { x: -2, y: 2, theta: -QUARTER } }),
  hints: () => [],
  legend: () => [],
  paint: () => ({
    viewIn: () => ({ ground: null, lines: [], dots: [] }),
    cornersIn: () => [],
    close: () => {},
  }),
};
const SCENE = { ...emptyScene, robot: { x: 1, y: 1, theta: 0 }, odom: { x: 1, y: 0, theta: 0 } };

describe("a place on the map", () => {
  const setUp = (pick: Pick, actions: object[] = []) => {
    const sent: { url: string; body: unknown }[] = [];
    vi.stubGlobal("fetch", async (request: Request) => {
      if (request.method === "GET") return Response.json({ actions });
      sent.push({ url: request.url, body: await request.json() });
      return Response.json({ goal_id: "1" }, { status: 202 });
    });
    const gateway = fakeGateway();
    const { services, fleet, store } = robotServices(gateway);
    services.scene.push(SCENE, 0);
    renderWithin(
      fleet,
      <ServicesProvider value={{ ...services, layers: [LAYER] }}>
        <MapMenu pick={pick} onClose={() => {}} />
      </ServicesProvider>,
    );
    return { gateway, store, sent, user: userEvent.setup() };
  };
  const NAVIGATOR = {
    action_name: "/navigate_to_pose",
    action_type: "nav2_msgs/action/NavigateToPose",
    available: true,
    hint: null,
  };

  it("docks the robot at its dock, without a question where it is simulated", async () => {
    const dock = { name: "lab", pose: { x: 0, y: 0, theta: 0 } };
    const { gateway, store, user } = setUp({ at: { x: 0, y: 0 }, point: { x: 0, y: 0 }, dock });
    act(() => store.robot.setSimulator(simulator));
    await user.click(await screen.findByRole("menuitem", { name: "Dock here" }));
    await waitFor(() => expect(gateway.dock).toHaveBeenCalledWith(null, "lab"));
  });

  it("is where the robot is sent to, after a question that names the pose", async () => {
    const { sent, user } = setUp({ at: { x: 0, y: 0 }, point: { x: 4, y: 1 }, dock: null }, [NAVIGATOR]);
    await user.click(await screen.findByRole("menuitem", { name: "Drive here" }));
    const question = await screen.findByRole("dialog", { name: "Drive the robot here?" });
    expect(question.textContent).toContain("x 1.00 m, y 6.00 m, heading 90° in the frame map");
    expect(sent).toEqual([]);
    await user.click(within(question).getByRole("button", { name: "Drive here" }));
    await waitFor(() => expect(sent).toHaveLength(1));
    expect(sent[0]?.url).toMatch(/\/actions\/navigate_to_pose\/goals$/);
    expect(sent[0]?.body).toMatchObject({ pose: { header: { frame_id: "map" } } });
  });

  it("has no menu where nothing can be done", () => {
    setUp({ at: { x: 0, y: 0 }, point: { x: 4, y: 1 }, dock: null });
    expect(screen.queryByRole("menu")).toBeNull();
  });

  it("becomes a goal of nav2", () => {
    const { pose } = poseGoal("map", { x: 1, y: 2, theta: Math.PI }).pose;
    expect(pose.position).toEqual({ x: 1, y: 2, z: 0 });
    expect([pose.orientation.z, pose.orientation.w].map((each) => each.toFixed(3))).toEqual([
      "1.000",
      "0.000",
    ]);
  });
});
