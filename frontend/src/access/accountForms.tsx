import type { ClientError } from "@dock-gateway/client";
import { Fieldset, NativeSelect, NumberInput, Stack, Switch, TagsInput, TextInput } from "@mantine/core";
import type { UseMutationResult } from "@tanstack/react-query";
import { type FormEvent, useState } from "react";
import type { CreatedToken, Token, TokenBody, User, UserBody } from "../api/access";
import { LIMITS } from "../api/limits.gen";
import { ROLES, type Role } from "../api/session";
import type { Base } from "../api/version";
import { useFleetTopic, useNaming } from "../fleet/context";
import { Conflict, isConflict } from "../ui/Conflict";
import { SaveBar } from "../ui/Dialog";
import { NewPassword, passwordProblem } from "./PasswordDialog";

/** The names that the gateway allows. */
const NAME = /^[a-z0-9](?:[a-z0-9._@+-]{0,58}[a-z0-9])?$/;

/** What a form for a new user or token starts from. */
export interface Example {
  name: string;
  role: Role;
}

interface UserFormProps {
  /** Who is changed; null for a new user. */
  user: User | null;
  example?: Example | undefined;
  /** All users, as they are now. */
  users: readonly User[];
  save: UseMutationResult<void, ClientError, { name: string; body: UserBody; base: Base }>;
  /** Begins anew with a user that someone else has changed. */
  onShow: (newest: User) => void;
  onDone: () => void;
}

/** Adds a user, or changes one. */
export function UserForm({ user, example, users, save, onShow, onDone }: UserFormProps) {
  const [name, setName] = useState(user?.name ?? example?.name ?? "");
  const [grant, setGrant] = useState<Grant>(
    user === null ? { role: example?.role ?? "viewer", ...NO_LIMITS } : grantOf(user),
  );
  const [disabled, setDisabled] = useState(user?.disabled ?? false);
  const [password, setPassword] = useState("");
  const [tried, setTried] = useState(false);
  const newest = users.find((each) => each.name === name);
  const wrongName = user === null ? nameProblem(name, newest !== undefined) : null;
  const keeps = user !== null && password === "";
  const store = (base: User | null) => {
    setTried(true);
    if (wrongName !== null || (!keeps && passwordProblem(password) !== null) || wrongLimits(grant).length > 0)
      return;
    const body = { ...grant, disabled, ...(keeps ? {} : { password }) };
    save.mutate({ name, body, base }, { onSuccess: onDone });
  };
  const submit = (event: FormEvent) => {
    event.preventDefault();
    store(user);
  };
  return (
    <form onSubmit={submit} noValidate>
      <Stack gap="md">
        {user === null && (
          <TextInput
            label="Name"
            description="Used to log in, and shown with what the user does."
            placeholder="ada"
            autoComplete="off"
            autoCapitalize="none"
            spellCheck={false}
            maxLength={LIMITS["POST /session"].user.maxLength}
            value={name}
            error={tried && wrongName}
            onChange={(event) => setName(event.currentTarget.value.toLowerCase())}
            data-autofocus
          />
        )}
        <GrantFields grant={grant} tried={tried} onChange={(part) => setGrant({ ...grant, ...part })} />
        <NewPassword
          label={user === null ? "Password" : "New password"}
          value={password}
          tried={tried}
          onChange={setPassword}
          {...(user === null ? {} : { empty: "Leave empty to keep the present one." })}
        />
        {user !== null && (
          <Switch
            label="Disabled"
            description="Cannot log in, and is logged out everywhere."
            checked={disabled}
            onChange={(event) => setDisabled(event.currentTarget.checked)}
          />
        )}
        <SaveBar
          save={save}
          onCancel={onDone}
          verb={user === null ? "Add" : "Save"}
          command={user === null ? "Adding the user" : "Saving"}
          trouble={isConflict(save.error) && <Conflict newest={newest} onShow={onShow} onReplace={store} />}
        />
      </Stack>
    </form>
  );
}

function grantOf({ role, robots, actions, topics }: User): Grant {
  return { role, robots, actions, topics };
}

function nameProblem(name: string, taken: boolean): string | null {
  if (name === "") return "Type a name.";
  if (!NAME.test(name)) return "Names have letters, digits, and . _ - @ + between them.";
  return taken ? "There is a user of this name." : null;
}

const { name: TOKEN_NAME, days: DAYS } = LIMITS["POST /tokens"];
const USUAL_DAYS = 90;

interface TokenFormProps {
  example?: Example | undefined;
  create: UseMutationResult<CreatedToken, ClientError, TokenBody>;
  onDone: (created: CreatedToken) => void;
  onCancel: () => void;
}

/** Creates a token for a person or a script. */
export function TokenForm({ example, create, onDone, onCancel }: TokenFormProps) {
  const [name, setName] = useState(example?.name ?? "");
  const [grant, setGrant] = useState<Grant>({ role: example?.role ?? "viewer", ...NO_LIMITS });
  const [days, setDays] = useState<number | string>(USUAL_DAYS);
  const [tried, setTried] = useState(false);
  const missing = name.trim() === "";
  const submit = (event: FormEvent) => {
    event.preventDefault();
    setTried(true);
    if (missing || wrongLimits(grant).length > 0) return;
    const body = { name: name.trim(), ...grant, days: typeof days === "number" ? days : null };
    create.mutate(body, { onSuccess: onDone });
  };
  return (
    <form onSubmit={submit} noValidate>
      <Stack gap="md">
        <TextInput
          label="Name"
          description="The person or the script that uses it; shown with what is done with it."
          placeholder="Ada"
          autoComplete="off"
          maxLength={TOKEN_NAME.maxLength}
          value={name}
          error={tried && missing && "Type a name."}
          onChange={(event) => setName(event.currentTarget.value)}
          data-autofocus
        />
        <GrantFields grant={grant} tried={tried} onChange={(part) => setGrant({ ...grant, ...part })} />
        <NumberInput
          label="Valid for (days)"
          description="Leave empty for a token that is valid until it is revoked."
          min={DAYS.minimum}
          max={DAYS.maximum}
          allowDecimal={false}
          clampBehavior="strict"
          value={days}
          onChange={setDays}
        />
        <SaveBar save={create} onCancel={onCancel} verb="Create" command="Creating the token" />
      </Stack>
    </form>
  );
}

export type Grant = Pick<Token, "role" | "robots" | "actions" | "topics">;

const NO_LIMITS = { robots: [], actions: [], topics: [] };

/** The patterns of robots that the gateway allows. */
const PATTERN = /^(?!.*\/\/)(?:\/[A-Za-z0-9_/*]*|\*[A-Za-z0-9_/*]+)$/;
const PATTERNS = [
  ["robots", "Robots", "/robot1 or /hall_a/*; empty for every robot.", "Every robot"],
  ["actions", "Actions", "*/connect_to_charging_dock; empty for every action of the robots.", "Every action"],
  ["topics", "Topics", "*/battery_status; empty for every topic of the robots.", "Every topic"],
] as const;

/** The limits that are not patterns of names. */
function wrongLimits(grant: Grant): string[] {
  return PATTERNS.flatMap(([name]) => grant[name]).filter((pattern) => !PATTERN.test(pattern));
}

interface GrantFieldsProps {
  grant: Grant;
  /** What is wrong is said from the first try on. */
  tried: boolean;
  onChange: (part: Partial<Grant>) => void;
}

/** What somebody may do, and with which robots, actions and topics. */
function GrantFields({ grant, tried, onChange }: GrantFieldsProps) {
  const robots = useNaming().inOrder(useFleetTopic("robots").keys());
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
            {PATTERNS.map(([name, label, description, placeholder]) => (
              <TagsInput
                key={name}
                label={label}
                description={description}
                placeholder={grant[name].length === 0 ? placeholder : ""}
                data={name === "robots" ? robots : []}
                maxTags={LIMITS["POST /tokens"][name].maxItems}
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
  return PATTERNS.flatMap(([name]) => grant[name]).join(", ");
}

/** What somebody with a role may do besides what those before it may. */
const ROLE_WORDS: Record<Role, string> = {
  viewer: "Sees its robots, and may stop every robot.",
  agent:
    "For programs of language models: as viewer, and sends goals. A person has to allow those to real robots.",
  operator: "Also docks and undocks, sends and cancels goals, adds notes, and acknowledges alerts.",
  supervisor: "Also releases stops, and changes names, groups and what the gateway does by itself.",
  admin: "Also adds and changes users and tokens, and sees who did what.",
};
