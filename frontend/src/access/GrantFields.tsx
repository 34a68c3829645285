import { Fieldset, NativeSelect, Stack, TagsInput } from "@mantine/core";
import type { Token } from "../api/access";
import { ROLES } from "../api/permissions";
import type { Role } from "../api/session";
import { useFleetTopic } from "../fleet/context";

export type Grant = Pick<Token, "role" | "robots" | "actions" | "topics">;

export const NO_LIMITS = { robots: [], actions: [], topics: [] };

/** As the gateway allows. */
const MAX_PATTERNS = 50;
const PATTERN = /^(?!.*\/\/)(?:\/[A-Za-z0-9_/*]*|\*[A-Za-z0-9_/*]+)$/;
const LIMITS = [
  ["robots", "Robots", "/robot1 or /hall_a/*; empty for every robot.", "Every robot"],
  ["actions", "Actions", "*/connect_to_charging_dock; empty for every action of the robots.", "Every action"],
  ["topics", "Topics", "*/battery_status; empty for every topic of the robots.", "Every topic"],
] as const;

/** The limits that are not patterns of names. */
export function wrongLimits(grant: Grant): string[] {
  return LIMITS.flatMap(([name]) => grant[name]).filter((pattern) => !PATTERN.test(pattern));
}

interface GrantFieldsProps {
  grant: Grant;
  /** What is wrong is said from the first try on. */
  tried: boolean;
  onChange: (part: Partial<Grant>) => void;
}

/** What somebody may do, and with which robots, actions and topics. */
export function GrantFields({ grant, tried, onChange }: GrantFieldsProps) {
  const robots = [...useFleetTopic("robots").keys()].sort();
  const choose = (role: Role) => onChange(role === "admin" ? { role, ...NO_LIMITS } : { role });
  return (
    <>
      <NativeSelect
        label="Role"
        description={ROLE_WORDS[grant.role]}
        data={[...ROLES]}
        value={grant.role}
        onChange={(event) => choose(event.currentTarget.value as Role)}
      />
      {grant.role !== "admin" && (
        <Fieldset legend="Only for">
          <Stack gap="sm">
            {LIMITS.map(([name, label, description, placeholder]) => (
              <TagsInput
                key={name}
                label={label}
                description={description}
                placeholder={grant[name].length === 0 ? placeholder : ""}
                data={name === "robots" ? robots : []}
                maxTags={MAX_PATTERNS}
                value={grant[name]}
                error={
                  tried && wrongLimits({ ...grant, ...NO_LIMITS, [name]: grant[name] }).length > 0 && WRONG
                }
                onChange={(patterns) => onChange({ [name]: patterns })}
                acceptValueOnBlur
              />
            ))}
          </Stack>
        </Fieldset>
      )}
    </>
  );
}

const WRONG = "Names begin with / or *, and have letters, digits, _, / and *.";

/** A grant's limits in words; empty without any. */
export function limitWords(grant: Grant): string {
  return LIMITS.flatMap(([name]) => grant[name]).join(", ");
}

/** What somebody with a role may do besides what those before it may. */
export const ROLE_WORDS: Record<Role, string> = {
  viewer: "Sees its robots, and may stop every robot.",
  operator: "Also docks and undocks, sends and cancels goals, adds notes, and acknowledges alerts.",
  supervisor: "Also releases stops, and changes rules, webhooks, names and groups.",
  admin: "Also adds and changes users and tokens, and reads the audit log.",
};
