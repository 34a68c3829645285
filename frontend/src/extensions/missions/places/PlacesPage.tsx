import { Alert, Button, Group, NativeSelect, NumberInput, SimpleGrid, Stack, TextInput } from "@mantine/core";
import { useState } from "react";
import { EntryCard } from "../../../entries/EntryCard";
import { EntryForm } from "../../../entries/EntryForm";
import { useFleetTopic, useNaming, useWhyNot } from "../../../fleet/context";
import { byName } from "../../../fleet/names";
import { isThere } from "../../../fleet/words";
import { Dialog } from "../../../ui/Dialog";
import { Empty } from "../../../ui/Empty";
import { ReasonButton } from "../../../ui/ReasonButton";
import { StoredPage } from "../StoredPage";
import { useStoredCommands } from "../stored";
import {
  bodyOf,
  draftOf,
  errorsOf,
  type NamedPlace,
  PLACES,
  type PlaceDraft,
  poseWords,
  usePlaces,
} from "./places";
import { robotPose } from "./robotPose";

/** The places that missions drive to. */
export default function PlacesPage() {
  const query = usePlaces();
  const reason = useWhyNot("PUT /places/{place_id}", query.data !== undefined);
  const { remove } = useStoredCommands(PLACES);
  const [edited, setEdited] = useState<{ place: NamedPlace | null } | null>(null);
  const close = () => setEdited(null);
  return (
    <>
      <StoredPage
        title="Places"
        what="places"
        button={
          <ReasonButton reason={reason} onClick={() => setEdited({ place: null })}>
            New place
          </ReasonButton>
        }
        query={query}
        empty={
          <Empty title="No places">
            A place is a position with a name, such as a shelf or a waiting area. Missions drive to it, and
            templates take it as a parameter. Type its coordinates, or drive a robot there and take where it
            stands.
          </Empty>
        }
      >
        {(places) =>
          places.map((place) => (
            <EntryCard
              key={place.id}
              entry={place}
              words={[poseWords(place), `In missions: ${place.id}`]}
              control={null}
              reason={reason}
              onEdit={() => setEdited({ place })}
              remove={remove}
              removal="Steps that drive to it fail when they begin."
            >
              {null}
            </EntryCard>
          ))
        }
      </StoredPage>
      <Dialog
        opened={edited !== null}
        onClose={close}
        title={edited?.place ? `Edit ${edited.place.name}` : "New place"}
      >
        {edited !== null && <PlaceForm place={edited.place} places={query.data ?? []} onDone={close} />}
      </Dialog>
    </>
  );
}

interface PlaceFormProps {
  /** Null for a new one. */
  place: NamedPlace | null;
  places: readonly NamedPlace[];
  onDone: () => void;
}

function PlaceForm({ place, places, onDone }: PlaceFormProps) {
  const { save } = useStoredCommands(PLACES);
  return (
    <EntryForm
      noun="place"
      entry={place}
      draftOf={draftOf}
      example={undefined}
      entries={places}
      placeholder="Shelf A3"
      maxName={60}
      errorsOf={errorsOf}
      bodyOf={(draft, by) => bodyOf(draft, by)}
      save={save}
      onSaved={onDone}
      onCancel={onDone}
    >
      {(draft, errors, change) => (
        <>
          <FromRobot onPose={change} />
          <SimpleGrid cols={{ base: 1, xs: 2 }} spacing="sm">
            <NumberInput
              label="X"
              suffix=" m"
              value={draft.x}
              error={errors.x}
              onChange={(x) => change({ x })}
            />
            <NumberInput
              label="Y"
              suffix=" m"
              value={draft.y}
              error={errors.y}
              onChange={(y) => change({ y })}
            />
            <NumberInput
              label="Heading"
              suffix="°"
              value={draft.heading}
              error={errors.heading}
              onChange={(heading) => change({ heading })}
            />
            <TextInput
              label="Frame"
              value={draft.frame}
              error={errors.frame}
              onChange={(event) => change({ frame: event.currentTarget.value })}
            />
          </SimpleGrid>
        </>
      )}
    </EntryForm>
  );
}

/** Fills in where a robot stands now. */
function FromRobot({ onPose }: { onPose: (pose: Partial<PlaceDraft>) => void }) {
  const naming = useNaming();
  const robots = useFleetTopic("robots");
  const names = [...robots.values()].flatMap((each) => (isThere(each) ? [each.name] : [])).sort(byName);
  const [chosen, choose] = useState<string | null>(null);
  const [state, setState] = useState<"idle" | "asking" | "unknown">("idle");
  const robot = chosen ?? names[0];
  if (robot === undefined) return null;
  const ask = async () => {
    setState("asking");
    const pose = await robotPose(robot);
    setState(pose === null ? "unknown" : "idle");
    if (pose !== null) onPose(pose);
  };
  return (
    <Stack gap="xs">
      <Group gap="sm" align="flex-end">
        {names.length > 1 && (
          <NativeSelect
            label="Robot"
            value={robot}
            onChange={(event) => choose(event.currentTarget.value)}
            data={names.map((name) => ({ value: name, label: naming.fullNameOf(name) }))}
          />
        )}
        <Button variant="default" loading={state === "asking"} onClick={() => void ask()}>
          Use where {names.length > 1 ? "it" : naming.nameOf(robot)} stands now
        </Button>
      </Group>
      {state === "unknown" && (
        <Alert color="orange" role="alert">
          Nobody knows where {naming.nameOf(robot)} is: it has no localization. Type the coordinates.
        </Alert>
      )}
    </Stack>
  );
}
