import { type components, deadline, type Http, type paths, settle } from "@dock-gateway/client";
import { type Base, ifUnchanged } from "../../../api/version";

/** Queues missions by itself. */
export type Schedule = components["schemas"]["MissionSchedule"];
export type ScheduleBody =
  paths["/schedules/{schedule_id}"]["put"]["requestBody"]["content"]["application/json"];

export async function listSchedules(http: Http): Promise<Schedule[]> {
  return (await settle(http.GET("/schedules", { signal: deadline() }))).schedules;
}

/** @param base The schedule that it replaces, as it was read. */
export function putSchedule(http: Http, id: string, body: ScheduleBody, base: Base): Promise<Schedule> {
  const params = { path: { schedule_id: id }, header: ifUnchanged(base) };
  return settle(http.PUT("/schedules/{schedule_id}", { params, body, signal: deadline() }));
}

export async function deleteSchedule(http: Http, schedule: { id: string; etag: string }): Promise<void> {
  const params = { path: { schedule_id: schedule.id }, header: ifUnchanged(schedule) };
  await settle(http.DELETE("/schedules/{schedule_id}", { params, signal: deadline() }));
}
