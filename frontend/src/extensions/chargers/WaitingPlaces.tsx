import { Button, Fieldset, Group, Stack, Text } from "@mantine/core";
import { useState } from "react";
import { LIMITS } from "../../api/limits.gen";
import { FromRobot, PoseFields } from "../../scene/PoseFields";
import { type PoseDraft, poseDraft, poseErrors, poseOf, poseWords } from "../../scene/poseDraft";
import type { DockPose } from "./requests";

const { maxItems: MAX_PLACES } = LIMITS["PUT /shared-docks/{dock_id}"].waiting_places;

interface WaitingPlacesProps {
  places: readonly DockPose[];
  onChange: (places: DockPose[]) => void;
}

/** Where robots wait for a dock: a list that grows by where a robot stands, or by coordinates. */
export function WaitingPlaces({ places, onChange }: WaitingPlacesProps) {
  const [typed, setTyped] = useState<PoseDraft | null>(null);
  const [tried, setTried] = useState(false);
  const errors = typed === null ? {} : poseErrors(typed);
  const add = (draft: PoseDraft) => {
    const place = poseOf(draft);
    if (!places.some((each) => poseWords(each) === poseWords(place))) onChange([...places, place]);
    setTyped(null);
    setTried(false);
  };
  const addTyped = () => (Object.keys(errors).length > 0 ? setTried(true) : typed !== null && add(typed));
  return (
    <Fieldset legend="Where robots wait for it">
      <Stack gap="sm">
        {places.length === 0 ? (
          <Text size="sm" c="dimmed">
            Robots on missions drive there with nav2, one to each place. Without places, they wait where they
            are.
          </Text>
        ) : (
          <Stack component="ol" gap="xs" m={0} p={0} style={{ listStyle: "none" }}>
            {places.map((place, index) => (
              <Group component="li" key={poseWords(place)} justify="space-between" wrap="nowrap">
                <Text size="sm">{poseWords(place)}</Text>
                <Button
                  variant="default"
                  size="compact-sm"
                  aria-label={`Remove place ${index + 1}`}
                  onClick={() => onChange(places.filter((_, at) => at !== index))}
                >
                  Remove
                </Button>
              </Group>
            ))}
          </Stack>
        )}
        {typed !== null ? (
          <>
            <PoseFields
              draft={typed}
              errors={tried ? errors : {}}
              onChange={(part) => setTyped({ ...typed, ...part })}
            />
            <Group gap="sm">
              <Button variant="default" onClick={addTyped}>
                Add it
              </Button>
              <Button variant="default" onClick={() => setTyped(null)}>
                Do not add it
              </Button>
            </Group>
          </>
        ) : (
          places.length < MAX_PLACES && (
            <Group gap="sm" align="flex-end">
              <FromRobot verb="Add" onPose={add} />
              <Button variant="default" onClick={() => setTyped(poseDraft(null))}>
                Type a place
              </Button>
            </Group>
          )
        )}
      </Stack>
    </Fieldset>
  );
}
