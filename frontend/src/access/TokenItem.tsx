import type { Token } from "../api/access";
import { ENTRY_BUTTON } from "../ui/EntryCard";
import { Fact } from "../ui/Fact";
import { ReasonButton } from "../ui/ReasonButton";
import { Time } from "../ui/Time";
import { AccountItem } from "./AccountItem";

interface TokenItemProps {
  token: Token;
  /** Why it cannot be revoked now; null where it can. */
  reason: string | null;
  onRevoke: () => void;
}

/** A token: whose it is, what they may do, and until when. */
export function TokenItem({ token, reason, onRevoke }: TokenItemProps) {
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
