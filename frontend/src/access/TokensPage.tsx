import type { ClientError } from "@dock-gateway/client";
import { Code, Group, Skeleton, Stack, Text } from "@mantine/core";
import type { UseMutationResult } from "@tanstack/react-query";
import { useState } from "react";
import type { CreatedToken, Token } from "../api/access";
import { useForbidden } from "../api/session";
import { useWhyNot } from "../fleet/context";
import { CopyButton } from "../ui/CopyButton";
import { Dialog, RemovalDialog } from "../ui/Dialog";
import { Empty } from "../ui/Empty";
import { Trouble } from "../ui/errors";
import { Fact } from "../ui/Fact";
import { ENTRY_BUTTON, ReasonButton } from "../ui/ReasonButton";
import { PageTitle } from "../ui/Section";
import { Time } from "../ui/Time";
import classes from "./access.module.css";
import { type Example, TokenForm } from "./accountForms";
import { AccountItem, useTokens } from "./accounts";
import { OpenNotice } from "./OpenNotice";
import { loginName } from "./who";

/** The tokens of those who use the gateway; for admins. */
export default function TokensPage() {
  const forbidden = useForbidden("GET /tokens");
  const { tokens, error, refetch, create, revoke } = useTokens();
  /** What the form starts from; null for nothing, undefined for no form. */
  const [creating, setCreating] = useState<Example | null>();
  const [created, setCreated] = useState<CreatedToken | null>(null);
  const [revoked, setRevoked] = useState<Token | null>(null);
  const reason = useWhyNot("GET /tokens", tokens !== undefined);
  const closeForm = () => {
    setCreating(undefined);
    create.reset();
  };
  const closeRevoke = () => {
    setRevoked(null);
    revoke.reset();
  };
  return (
    <Stack gap="md">
      <PageTitle title="Tokens" help="access#limits">
        <ReasonButton reason={reason} onClick={() => setCreating(null)}>
          New token
        </ReasonButton>
      </PageTitle>
      <OpenNotice />
      <Trouble what="The tokens could not be loaded" error={error} onRetry={() => void refetch()} />
      {tokens !== undefined ? (
        <TokenList tokens={tokens} reason={reason} onRevoke={setRevoked} onExample={setCreating} />
      ) : forbidden !== null ? (
        <Text size="sm">{forbidden}</Text>
      ) : (
        error === null && <Skeleton height={90} role="status" aria-label="The tokens are loading" />
      )}
      <Dialog opened={creating !== undefined} onClose={closeForm} title="New token">
        {creating !== undefined && (
          <TokenForm
            example={creating ?? undefined}
            create={create}
            onDone={(token) => {
              closeForm();
              setCreated(token);
            }}
            onCancel={closeForm}
          />
        )}
      </Dialog>
      <Dialog
        opened={created !== null}
        onClose={() => setCreated(null)}
        title={created === null ? "" : `The token of ${created.name}`}
      >
        {created !== null && <Secret secret={created.secret} />}
      </Dialog>
      <RevokeDialog token={revoked} revoke={revoke} onClose={closeRevoke} />
    </Stack>
  );
}

interface TokenListProps {
  tokens: readonly Token[];
  reason: string | null;
  onRevoke: (token: Token) => void;
  onExample: (example: Example) => void;
}

/** A token to start from. */
const EXAMPLE: Example = { name: "Night script", role: "operator" };

function TokenList({ tokens, reason, onRevoke, onExample }: TokenListProps) {
  if (tokens.length === 0)
    return (
      <Empty
        title="No tokens"
        examples={
          <ReasonButton variant="default" reason={reason} onClick={() => onExample(EXAMPLE)}>
            Example: a script that docks robots
          </ReasonButton>
        }
      >
        Each person and each script gets one of their own, so that it can be revoked alone.
      </Empty>
    );
  return (
    <Stack component="ul" gap="sm" m={0} p={0} aria-label="Tokens">
      {tokens.map((token) => (
        <TokenItem key={token.id} token={token} reason={reason} onRevoke={() => onRevoke(token)} />
      ))}
    </Stack>
  );
}

function Secret({ secret }: { secret: string }) {
  return (
    <Stack gap="md">
      <Text size="sm">
        Copy it now: it is not shown again. Give it only to the person or the script that it is for.
      </Text>
      <Group gap="sm" wrap="nowrap" align="start">
        <Code block className={classes.secret ?? ""}>
          {secret}
        </Code>
        <CopyButton value={secret} what="the token" />
      </Group>
    </Stack>
  );
}

interface RevokeDialogProps {
  /** Null for none: then it is closed. */
  token: Token | null;
  revoke: UseMutationResult<void, ClientError, string>;
  onClose: () => void;
}

/** Asks before a token is revoked, and says what ends with it. */
function RevokeDialog({ token, revoke, onClose }: RevokeDialogProps) {
  return (
    <RemovalDialog
      title={`Revoke the token of ${token?.name}?`}
      opened={token !== null}
      onClose={onClose}
      remove={revoke}
      onRemove={() => token !== null && revoke.mutate(token.id, { onSuccess: onClose })}
      verb="Revoke"
    >
      <Text size="sm">
        Requests with it are refused, and the open pages and streams of {token?.name} end: here at once, at
        other gateways within 2 s. Goals that {token?.name} has sent go on. A revoked token cannot be
        restored.
      </Text>
      {token !== null && token.name === loginName() && (
        <Text size="sm" fw={600}>
          You are logged in with this token: this page will ask you to log in.
        </Text>
      )}
    </RemovalDialog>
  );
}

interface TokenItemProps {
  token: Token;
  /** Why it cannot be revoked now; null where it can. */
  reason: string | null;
  onRevoke: () => void;
}

/** A token: whose it is, what they may do, and until when. */
function TokenItem({ token, reason, onRevoke }: TokenItemProps) {
  const { name, expires_at, used_at, valid } = token;
  return (
    <AccountItem
      account={token}
      flaw={valid ? null : "expired"}
      begun="Created"
      buttons={
        <ReasonButton {...ENTRY_BUTTON} reason={reason} aria-label={`Revoke ${name}`} onClick={onRevoke}>
          Revoke
        </ReasonButton>
      }
    >
      <Fact name={valid ? "Expires" : "Expired"}>
        {expires_at === null ? "Never" : <Time value={expires_at} />}
      </Fact>
      <Fact name="Last used">{used_at === null ? "Never" : <Time value={used_at} />}</Fact>
    </AccountItem>
  );
}
