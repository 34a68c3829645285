import { Code, Group, Skeleton, Stack, Text, Title } from "@mantine/core";
import { useState } from "react";
import type { CreatedToken, Token } from "../api/access";
import { useForbidden } from "../api/permissions";
import { useWhyNot } from "../fleet/useWhyNot";
import { CopyButton } from "../ui/CopyButton";
import { Dialog } from "../ui/Dialog";
import { ReasonButton } from "../ui/ReasonButton";
import { Trouble } from "../ui/Trouble";
import { usePageTitle } from "../ui/usePageTitle";
import classes from "./access.module.css";
import { OpenNotice } from "./OpenNotice";
import { RevokeDialog } from "./RevokeDialog";
import { TokenForm } from "./TokenForm";
import { TokenItem } from "./TokenItem";
import { useTokens } from "./useTokens";

/** The tokens of those who use the gateway; for admins. */
export default function TokensPage() {
  usePageTitle("Tokens");
  const forbidden = useForbidden("GET /tokens");
  const { tokens, error, refetch, create, revoke } = useTokens();
  const [creating, setCreating] = useState(false);
  const [created, setCreated] = useState<CreatedToken | null>(null);
  const [revoked, setRevoked] = useState<Token | null>(null);
  const reason = useWhyNot("GET /tokens", tokens !== undefined);
  const closeForm = () => {
    setCreating(false);
    create.reset();
  };
  const closeRevoke = () => {
    setRevoked(null);
    revoke.reset();
  };
  return (
    <Stack gap="md">
      <Group justify="space-between" gap="xs">
        <Title order={1} size="h3">
          Tokens
        </Title>
        <ReasonButton reason={reason} onClick={() => setCreating(true)}>
          New token
        </ReasonButton>
      </Group>
      <OpenNotice />
      <Trouble what="The tokens could not be loaded" error={error} onRetry={() => void refetch()} />
      {tokens !== undefined ? (
        <TokenList tokens={tokens} reason={reason} onRevoke={setRevoked} />
      ) : forbidden !== null ? (
        <Text size="sm">{forbidden}</Text>
      ) : (
        error === null && <Skeleton height={90} role="status" aria-label="The tokens are loading" />
      )}
      <Dialog opened={creating} onClose={closeForm} title="New token">
        {creating && (
          <TokenForm
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
}

function TokenList({ tokens, reason, onRevoke }: TokenListProps) {
  if (tokens.length === 0)
    return (
      <Text size="sm" c="dimmed" maw="44rem">
        No tokens. Each person and each script gets one of their own, so that it can be revoked alone.
      </Text>
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
