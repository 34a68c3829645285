-- The tables at revision 0018 as the migrations before the baseline made them, in PostgreSQL.
-- SQLite: without COLLATE "C", and with DATETIME instead of TIMESTAMP WITH TIME ZONE.

CREATE TABLE alembic_version (
    version_num VARCHAR(32) NOT NULL,
    CONSTRAINT alembic_version_pkc PRIMARY KEY (version_num)
);

CREATE TABLE goals (
    goal_id TEXT COLLATE "C" NOT NULL,
    action_name TEXT NOT NULL,
    action_type TEXT NOT NULL,
    origin TEXT NOT NULL,
    status TEXT NOT NULL,
    stalled BOOLEAN NOT NULL,
    goal TEXT,
    feedback TEXT,
    result TEXT,
    error_code TEXT,
    error_detail TEXT,
    created_at TIMESTAMP WITH TIME ZONE NOT NULL,
    updated_at TIMESTAMP WITH TIME ZONE NOT NULL,
    finished_at TIMESTAMP WITH TIME ZONE,
    feedback_count BIGINT NOT NULL,
    last_event_id TEXT,
    PRIMARY KEY (goal_id)
);

CREATE INDEX goals_by_time ON goals (created_at, goal_id);

CREATE INDEX goals_by_action ON goals (action_name, created_at, goal_id);

CREATE INDEX goals_by_status ON goals (status, created_at, goal_id);

CREATE TABLE events (
    id TEXT COLLATE "C" NOT NULL,
    topic TEXT NOT NULL,
    goal_id TEXT,
    action_name TEXT,
    robot TEXT,
    droppable BOOLEAN NOT NULL,
    size INTEGER NOT NULL,
    data TEXT NOT NULL,
    PRIMARY KEY (id)
);

CREATE INDEX events_by_goal ON events (goal_id, id);

CREATE INDEX droppable_events ON events (id, size) WHERE droppable;

CREATE TABLE idempotency_keys (
    key TEXT NOT NULL,
    goal_id TEXT NOT NULL,
    fingerprint TEXT NOT NULL,
    expires_at TIMESTAMP WITH TIME ZONE NOT NULL,
    PRIMARY KEY (key)
);

CREATE INDEX keys_by_expiry ON idempotency_keys (expires_at);

CREATE TABLE horizons (
    topic TEXT NOT NULL,
    event_id TEXT COLLATE "C" NOT NULL,
    PRIMARY KEY (topic)
);

INSERT INTO alembic_version (version_num) VALUES ('0018');

ALTER TABLE goals ADD COLUMN stage TEXT;

ALTER TABLE goals ADD COLUMN retries INTEGER;

CREATE INDEX battery_events ON events (robot, id) WHERE topic = 'battery';

CREATE TABLE acknowledgements (
    alert_id TEXT NOT NULL,
    name TEXT NOT NULL,
    acknowledged_at TIMESTAMP WITH TIME ZONE NOT NULL,
    PRIMARY KEY (alert_id)
);

ALTER TABLE events ADD COLUMN key TEXT COLLATE "C";

CREATE UNIQUE INDEX events_by_key ON events (key);

CREATE INDEX kept_events ON events (size) WHERE NOT droppable;

CREATE INDEX keys_by_goal ON idempotency_keys (goal_id);

INSERT INTO horizons (topic, event_id) VALUES ('', '01795659854189480419');

CREATE INDEX goals_by_error ON goals (error_code, created_at, goal_id) WHERE error_code IS NOT NULL;

CREATE INDEX goals_by_end ON goals (created_at, action_name, status, error_code, retries, finished_at);

CREATE TABLE robot_labels (
    robot TEXT NOT NULL,
    display_name TEXT,
    groups TEXT NOT NULL,
    PRIMARY KEY (robot)
);

CREATE TABLE goal_tags (
    goal_id TEXT COLLATE "C" NOT NULL,
    tag TEXT COLLATE "C" NOT NULL,
    PRIMARY KEY (goal_id, tag)
);

CREATE INDEX goals_by_tag ON goal_tags (tag, goal_id);

CREATE TABLE goal_notes (
    note_id TEXT COLLATE "C" NOT NULL,
    goal_id TEXT COLLATE "C" NOT NULL,
    author TEXT NOT NULL,
    written_at TIMESTAMP WITH TIME ZONE NOT NULL,
    text TEXT NOT NULL,
    PRIMARY KEY (note_id)
);

CREATE INDEX notes_by_goal ON goal_notes (goal_id, written_at, note_id);

CREATE TABLE automation_rules (
    rule_id TEXT NOT NULL,
    name TEXT NOT NULL,
    mode TEXT NOT NULL,
    every_robot BOOLEAN NOT NULL,
    robots TEXT NOT NULL,
    groups TEXT NOT NULL,
    below FLOAT,
    idle_s FLOAT,
    times TEXT NOT NULL,
    weekdays TEXT NOT NULL,
    time_zone TEXT,
    changed_by TEXT,
    changed_at TIMESTAMP WITH TIME ZONE NOT NULL,
    PRIMARY KEY (rule_id)
);

CREATE TABLE automation_decisions (
    decision_id TEXT NOT NULL,
    rule_id TEXT NOT NULL,
    rule_name TEXT NOT NULL,
    robot TEXT NOT NULL,
    decided_at TIMESTAMP WITH TIME ZONE NOT NULL,
    outcome TEXT NOT NULL,
    battery FLOAT,
    idle_since TIMESTAMP WITH TIME ZONE,
    scheduled_for TIMESTAMP WITH TIME ZONE,
    goal_id TEXT,
    code TEXT,
    detail TEXT,
    open BOOLEAN NOT NULL,
    PRIMARY KEY (decision_id)
);

CREATE TABLE webhooks (
    webhook_id TEXT NOT NULL,
    name TEXT NOT NULL,
    url TEXT NOT NULL,
    secret TEXT NOT NULL,
    enabled BOOLEAN NOT NULL,
    severities TEXT NOT NULL,
    every_robot BOOLEAN NOT NULL,
    robots TEXT NOT NULL,
    groups TEXT NOT NULL,
    changed_by TEXT,
    changed_at TIMESTAMP WITH TIME ZONE NOT NULL,
    PRIMARY KEY (webhook_id)
);

CREATE TABLE webhook_deliveries (
    delivery_id TEXT NOT NULL,
    webhook_id TEXT NOT NULL,
    event_type TEXT NOT NULL,
    state TEXT NOT NULL,
    alert_id TEXT,
    happened_at TIMESTAMP WITH TIME ZONE NOT NULL,
    body TEXT NOT NULL,
    attempts INTEGER NOT NULL,
    next_at TIMESTAMP WITH TIME ZONE,
    tried_at TIMESTAMP WITH TIME ZONE,
    status_code INTEGER,
    error TEXT,
    PRIMARY KEY (delivery_id)
);

ALTER TABLE goals ADD COLUMN verb TEXT;

CREATE TABLE tokens (
    token_id TEXT NOT NULL,
    name TEXT NOT NULL,
    role TEXT NOT NULL,
    digest TEXT NOT NULL,
    created_by TEXT,
    created_at TIMESTAMP WITH TIME ZONE NOT NULL,
    expires_at TIMESTAMP WITH TIME ZONE,
    used_at TIMESTAMP WITH TIME ZONE,
    PRIMARY KEY (token_id)
);

ALTER TABLE tokens ADD COLUMN robots TEXT DEFAULT '[]' NOT NULL;

ALTER TABLE tokens ADD COLUMN actions TEXT DEFAULT '[]' NOT NULL;

ALTER TABLE tokens ADD COLUMN topics TEXT DEFAULT '[]' NOT NULL;

CREATE TABLE audit (
    sequence BIGINT NOT NULL,
    entry_id TEXT NOT NULL,
    at TIMESTAMP WITH TIME ZONE NOT NULL,
    principal TEXT,
    role TEXT,
    token_id TEXT,
    client TEXT,
    request_id TEXT,
    what TEXT NOT NULL,
    robot TEXT,
    action_name TEXT,
    goal_id TEXT,
    subject TEXT,
    status INTEGER NOT NULL,
    code TEXT,
    digest TEXT NOT NULL,
    PRIMARY KEY (sequence)
);

CREATE UNIQUE INDEX audit_by_entry ON audit (entry_id);

CREATE INDEX audit_by_principal ON audit (principal, sequence);

CREATE INDEX audit_by_what ON audit (what, sequence);

CREATE INDEX audit_by_goal ON audit (goal_id, sequence);

CREATE TABLE audit_chain (
    chain_id INTEGER NOT NULL,
    anchor_sequence BIGINT NOT NULL,
    anchor_digest TEXT NOT NULL,
    head_sequence BIGINT NOT NULL,
    head_digest TEXT NOT NULL,
    PRIMARY KEY (chain_id)
);

INSERT INTO audit_chain (chain_id, anchor_sequence, anchor_digest, head_sequence, head_digest) VALUES (1, 0, '0000000000000000000000000000000000000000000000000000000000000000', 0, '0000000000000000000000000000000000000000000000000000000000000000');

CREATE TABLE users (
    name TEXT NOT NULL,
    role TEXT NOT NULL,
    robots TEXT NOT NULL,
    actions TEXT NOT NULL,
    topics TEXT NOT NULL,
    password TEXT NOT NULL,
    era TEXT NOT NULL,
    disabled BOOLEAN NOT NULL,
    created_by TEXT,
    created_at TIMESTAMP WITH TIME ZONE NOT NULL,
    logged_in_at TIMESTAMP WITH TIME ZONE,
    PRIMARY KEY (name)
);

CREATE TABLE sessions (
    session_id TEXT NOT NULL,
    user_name TEXT NOT NULL,
    era TEXT NOT NULL,
    digest TEXT NOT NULL,
    created_at TIMESTAMP WITH TIME ZONE NOT NULL,
    expires_at TIMESTAMP WITH TIME ZONE NOT NULL,
    used_at TIMESTAMP WITH TIME ZONE NOT NULL,
    PRIMARY KEY (session_id)
);

CREATE TABLE person_sessions (
    session_id TEXT NOT NULL,
    person TEXT NOT NULL,
    issuer TEXT NOT NULL,
    subject TEXT NOT NULL,
    role TEXT NOT NULL,
    robots TEXT NOT NULL,
    actions TEXT NOT NULL,
    topics TEXT NOT NULL,
    digest TEXT NOT NULL,
    attempt TEXT NOT NULL,
    created_at TIMESTAMP WITH TIME ZONE NOT NULL,
    expires_at TIMESTAMP WITH TIME ZONE NOT NULL,
    used_at TIMESTAMP WITH TIME ZONE NOT NULL,
    PRIMARY KEY (session_id)
);
