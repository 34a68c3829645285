import { Skeleton, Stack } from "@mantine/core";
import { useState } from "react";
import { useWhyNot } from "../../fleet/context";
import { Dialog } from "../../ui/Dialog";
import { Empty } from "../../ui/Empty";
import { Trouble } from "../../ui/errors";
import { ReasonButton } from "../../ui/ReasonButton";
import { PageTitle } from "../../ui/Section";
import { DockCard } from "./DockCard";
import { DockForm } from "./DockForm";
import { useDocks } from "./docks";
import type { SharedDock } from "./requests";

/** The docks that robots share: who stands there, who comes, and who waits. */
export default function DocksPage() {
  const { data: docks, error, refetch } = useDocks();
  const reason = useWhyNot("PUT /shared-docks/{dock_id}", docks !== undefined);
  /** The dock in the dialog; null for a new one, undefined for none. */
  const [edited, setEdited] = useState<SharedDock | null>();
  const close = () => setEdited(undefined);
  const add = (
    <ReasonButton reason={reason} onClick={() => setEdited(null)}>
      Share a dock
    </ReasonButton>
  );
  return (
    <Stack gap="md">
      <PageTitle title="Docks" help="extensions/chargers#on-the-dashboard">
        {docks !== undefined && docks.length > 0 && add}
      </PageTitle>
      <Trouble what="The docks could not be loaded" error={error} onRetry={() => void refetch()} />
      {docks === undefined ? (
        error === null && <Skeleton height={110} role="status" aria-label="The docks are loading" />
      ) : docks.length === 0 ? (
        <Empty title="No shared docks" examples={add}>
          Several robots that use one dock share it: enter its name, and at most one robot drives there.
          Missions and rules wait until it is free, and anybody else is told which robot has it.
        </Empty>
      ) : (
        <Stack component="ul" gap="sm" m={0} p={0} aria-label="Docks">
          {docks.map((dock) => (
            <DockCard key={dock.dock_id} dock={dock} onEdit={() => setEdited(dock)} />
          ))}
        </Stack>
      )}
      <Dialog
        opened={edited !== undefined}
        onClose={close}
        title={edited ? `Edit ${edited.dock_id}` : "Share a dock"}
      >
        {edited !== undefined && <DockForm dock={edited} docks={docks ?? []} onDone={close} />}
      </Dialog>
    </Stack>
  );
}
