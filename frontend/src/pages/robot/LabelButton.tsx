import { ActionIcon, Skeleton, Tooltip } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { Suspense } from "react";
import { useNaming, useWhyNot } from "../../fleet/context";
import { Dialog } from "../../ui/Dialog";
import { Guarded } from "../../ui/Guarded";
import { lazyPart } from "../../ui/lazyPart";

const LabelForm = lazyPart(() => import("./LabelForm"));

/** Opens the name and groups of a robot; has the focus again afterwards. */
export function LabelButton({ robot }: { robot: string }) {
  const naming = useNaming();
  const reason = useWhyNot("PUT /robots/label");
  const [opened, dialog] = useDisclosure(false);
  return (
    <>
      <Tooltip label={reason ?? "Name and groups"}>
        <ActionIcon
          variant="subtle"
          color="gray"
          size="lg"
          aria-label={`Name and groups of ${naming.nameOf(robot)}`}
          aria-haspopup="dialog"
          aria-disabled={reason !== null}
          onClick={() => reason === null && dialog.open()}
        >
          <svg width="18" height="18" viewBox="0 0 24 24" aria-hidden="true" fill="currentColor">
            <path d="M3 17.2V21h3.8L17.9 9.9l-3.8-3.8L3 17.2ZM20.7 7a1 1 0 0 0 0-1.4l-2.3-2.3a1 1 0 0 0-1.4 0l-1.8 1.8 3.8 3.8L20.7 7Z" />
          </svg>
        </ActionIcon>
      </Tooltip>
      <Dialog opened={opened} onClose={dialog.close} title={`Name and groups of ${naming.fullNameOf(robot)}`}>
        <Guarded of={robot}>
          <Suspense fallback={<Skeleton height={180} />}>
            <LabelForm robot={robot} onDone={dialog.close} />
          </Suspense>
        </Guarded>
      </Dialog>
    </>
  );
}
