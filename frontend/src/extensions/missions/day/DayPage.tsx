import { Skeleton, Stack } from "@mantine/core";
import { useMediaQuery } from "@mantine/hooks";
import { useNavigate } from "react-router";
import { useForbidden } from "../../../api/session";
import { useGatewayNow } from "../../../clock/clock";
import { useFleetTopic, useNaming, useWhyNot } from "../../../fleet/context";
import { namesThere } from "../../../fleet/words";
import { Empty } from "../../../ui/Empty";
import { Trouble } from "../../../ui/errors";
import { ReasonButton } from "../../../ui/ReasonButton";
import { PageTitle } from "../../../ui/Section";
import { useZone } from "../../../ui/zone";
import { useFreshMissions } from "../freshMissions";
import { MissionPages } from "../StoredPage";
import { useSchedules } from "../schedules/schedules";
import { dayAround } from "./axis";
import { rowsOf } from "./bars";
import { DayChart } from "./DayChart";
import { DayList } from "./DayList";
import { useMissionsSince } from "./dayMissions";
import { plansOf } from "./planned";

/** How often running bars grow (ms). */
const RENEW_MS = 5000;

/** The missions of today, of all robots, on a time axis; on a phone as a list. */
export default function DayPage() {
  useFreshMissions();
  useZone();
  const now = useGatewayNow(RENEW_MS);
  const day = dayAround(now);
  const narrow = useMediaQuery("(max-width: 40em)", false, { getInitialValueInEffect: false });
  const robots = useFleetTopic("robots");
  const naming = useNaming();
  const { missions, error, refetch } = useMissionsSince(day.from);
  const schedules = useSchedules();
  const there = namesThere(robots);
  const plans = plansOf(schedules.data ?? [], now, day.to);
  const rows = missions === undefined ? undefined : rowsOf(there, missions, plans, now, naming);
  const nothing = rows?.every(({ bars, next }) => bars.length === 0 && next === 0);
  return (
    <Stack gap="md">
      <PageTitle title="Missions of today" help="extensions/missions#on-the-dashboard" />
      <MissionPages />
      <Trouble what="The missions could not be loaded" error={error} onRetry={refetch} />
      <Trouble
        what="The schedules could not be loaded"
        error={schedules.error}
        onRetry={() => void schedules.refetch()}
      />
      {rows === undefined ? (
        error === null && <Skeleton height={240} role="status" aria-label="The missions are loading" />
      ) : nothing ? (
        <NothingToday />
      ) : narrow ? (
        <DayList rows={rows} />
      ) : (
        <DayChart rows={rows} day={day} now={now} />
      )}
    </Stack>
  );
}

function NothingToday() {
  const forbidden = useForbidden("POST /missions");
  const reason = useWhyNot("POST /missions");
  const navigate = useNavigate();
  return (
    <Empty
      title="No missions today"
      examples={
        forbidden === null && (
          <ReasonButton variant="default" reason={reason} onClick={() => navigate("/ui/missions/new")}>
            New mission
          </ReasonButton>
        )
      }
    >
      Here each robot has a row, and each of its missions is a bar from its start to its end, with its steps.
      What schedules will queue today has a dashed frame.
    </Empty>
  );
}
