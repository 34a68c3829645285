import { Button, Group, Stack, Text, TextInput } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { type FormEvent, useState } from "react";
import { MAX_NAME, ownName, setOwnName } from "../access/who";
import { createAlerts } from "../api/client";
import { useFleet, useWhyNot } from "../fleet/context";
import { Dialog } from "../ui/Dialog";
import { CommandErrorAlert } from "../ui/errors";
import { ReasonButton } from "../ui/ReasonButton";
import { useCommand } from "../ui/requests";
import classes from "./alerts.module.css";

/** Acknowledges an alert with the name that was given on this computer; asks for one where there is none. */
export function AcknowledgeButton({ id, what }: { id: string; what: string }) {
  const { http, store } = useFleet();
  const [asking, ask] = useDisclosure(false);
  const acknowledge = useCommand(async (by: string) =>
    store.setAlert(await createAlerts(http).acknowledge(id, by)),
  );
  const reason = useWhyNotAnswer(acknowledge.isPending);
  const press = () => {
    const name = ownName().trim();
    if (name === "") ask.open();
    else acknowledge.mutate(name);
  };
  return (
    <>
      <ReasonButton
        variant="default"
        size="compact-sm"
        className={classes.answer ?? ""}
        reason={reason}
        {...(reason === null ? { title: "Says to everybody that you have seen it" } : {})}
        aria-label={`Acknowledge: ${what}`}
        onClick={press}
      >
        Acknowledge
      </ReasonButton>
      {acknowledge.error !== null && (
        <div className={classes.failed}>
          <CommandErrorAlert command="Acknowledge" error={acknowledge.error} onClose={acknowledge.reset} />
        </div>
      )}
      <Dialog opened={asking} onClose={ask.close} title="Acknowledge as">
        <NameForm
          onName={(name) => {
            setOwnName(name);
            ask.close();
            acknowledge.mutate(name);
          }}
        />
      </Dialog>
    </>
  );
}

/** Why an alert can neither be acknowledged nor the acknowledgement be withdrawn now; null where it can. */
export function useWhyNotAnswer(sending: boolean): string | null {
  const reason = useWhyNot("PUT /alerts/{alert_id}/acknowledgement");
  return reason ?? (sending ? "The gateway has not answered yet." : null);
}

function NameForm({ onName }: { onName: (name: string) => void }) {
  const [name, setName] = useState("");
  const given = name.trim();
  const submit = (event: FormEvent) => {
    event.preventDefault();
    if (given !== "") onName(given);
  };
  return (
    <form onSubmit={submit}>
      <Stack gap="md">
        <Text size="sm">
          Everybody who has this dashboard open reads that you have seen the alert and look after it. It stays
          in the list until what it is about is over.
        </Text>
        <TextInput
          label="Your name"
          description="It is kept in this browser, for the next time and for Stop."
          autoComplete="name"
          maxLength={MAX_NAME}
          value={name}
          onChange={(event) => setName(event.currentTarget.value)}
          data-autofocus
        />
        <Group justify="flex-end">
          <Button
            type="submit"
            disabled={given === ""}
            title={given === "" ? "Type your name first." : undefined}
          >
            Acknowledge
          </Button>
        </Group>
      </Stack>
    </form>
  );
}
