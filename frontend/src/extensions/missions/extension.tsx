import type { Extension } from "../../extension/extension";
import { lazyPart } from "../../ui/lazyPart";
import { RobotMission } from "./openMissions";

export const extension: Extension = {
  name: "missions",
  pages: [
    {
      path: "/ui/missions",
      Page: lazyPart(() => import("./MissionsPage")),
      menu: { name: "Missions", letter: "i", order: 35 },
      at: "gateway",
    },
    { path: "/ui/missions/today", Page: lazyPart(() => import("./day/DayPage")), at: "gateway" },
    { path: "/ui/missions/new", Page: lazyPart(() => import("./NewMissionPage")), at: "gateway" },
    {
      path: "/ui/missions/templates",
      Page: lazyPart(() => import("./templates/TemplatesPage")),
      at: "gateway",
    },
    {
      path: "/ui/missions/schedules",
      Page: lazyPart(() => import("./schedules/SchedulesPage")),
      at: "gateway",
    },
    { path: "/ui/missions/places", Page: lazyPart(() => import("./places/PlacesPage")), at: "gateway" },
    {
      path: "/ui/missions/:missionId/edit",
      Page: lazyPart(() => import("./EditMissionPage")),
      at: "gateway",
    },
    { path: "/ui/missions/:missionId", Page: lazyPart(() => import("./MissionPage")), at: "gateway" },
  ],
  parts: { robotColumn: RobotMission },
};
