import { useState } from "react";
import { EntryCard } from "../../../entries/EntryCard";
import { EntryForm } from "../../../entries/EntryForm";
import { useWhyNot } from "../../../fleet/context";
import { FromRobot, PoseFields } from "../../../scene/PoseFields";
import { poseWords } from "../../../scene/poseDraft";
import { Dialog } from "../../../ui/Dialog";
import { Empty } from "../../../ui/Empty";
import { ReasonButton } from "../../../ui/ReasonButton";
import { StoredPage } from "../StoredPage";
import { useStoredCommands } from "../stored";
import { bodyOf, draftOf, errorsOf, type NamedPlace, PLACES, usePlaces } from "./places";

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
              words={[poseWords({ ...place, theta: place.yaw }), `In missions: ${place.id}`]}
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
          <PoseFields draft={draft} errors={errors} onChange={change} />
        </>
      )}
    </EntryForm>
  );
}
