import { Anchor } from "@mantine/core";
import { useEffect, useRef, useState } from "react";
import type { Places } from "../../extension/extension";
import { useFleet } from "../../fleet/context";
import { useAnswer } from "../../ui/requests";
import { watchSight } from "../../ui/sight";
import { AGAIN_MS, sizeText } from "./RecordingButton";
import { recordingOf, recordingUrl } from "./requests";

/** Downloads the recording of a goal that has ended, if there is one. It is asked for once its place is in sight. */
export function LinkedRecording({ goalId }: Places["linkedGoal"]) {
  const { http } = useFleet();
  const place = useRef<HTMLSpanElement>(null);
  const [seen, setSeen] = useState(false);
  useEffect(
    () =>
      place.current === null
        ? undefined
        : watchSight(place.current, (inSight) => {
            if (inSight) setSeen(true);
          }),
    [],
  );
  const { data } = useAnswer({
    queryKey: ["recording", goalId, "linked"],
    queryFn: () => recordingOf(http, goalId),
    enabled: seen,
    refetchInterval: ({ state }) => (state.data?.state === "running" ? AGAIN_MS : false),
  });
  const size = data?.size_bytes ?? null;
  return (
    <span ref={place}>
      {size !== null && (
        <Anchor href={recordingUrl(goalId)} download size="sm" underline="always">
          Recording, {sizeText(size)}
        </Anchor>
      )}
    </span>
  );
}
