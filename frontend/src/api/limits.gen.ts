// Made from openapi.json by `npm run types`.

/** By request, of those that a form is for: the limits of the fields of its body. */
export const LIMITS = {
  "POST /goals/{goal_id}/notes": {
    "by": { maxLength: 60 },
    "text": { maxLength: 2000 },
  },
  "POST /missions": {
    "name": { maxLength: 60 },
    "priority": { minimum: 0, maximum: 100 },
    "steps": { maxItems: 200 },
    "steps[].action.name": { maxLength: 255 },
    "steps[].wait.seconds": { minimum: 0, maximum: 604800 },
    "steps[].wait.battery": { maximum: 1 },
    "steps[].timeout_s": { minimum: 1, maximum: 604800 },
    "steps[].tries": { minimum: 1, maximum: 20 },
    "by": { maxLength: 60 },
  },
  "POST /session": {
    "user": { maxLength: 60 },
    "password": { minLength: 1, maxLength: 200 },
  },
  "POST /tokens": {
    "robots": { maxItems: 50 },
    "robots[]": { maxLength: 255 },
    "actions": { maxItems: 50 },
    "actions[]": { maxLength: 255 },
    "topics": { maxItems: 50 },
    "topics[]": { maxLength: 255 },
    "name": { maxLength: 60 },
    "days": { minimum: 1, maximum: 3650 },
  },
  "PUT /automation/rules/{rule_id}": {
    "name": { maxLength: 60 },
    "robots.names": { maxItems: 500 },
    "robots.names[]": { maxLength: 255 },
    "robots.groups": { maxItems: 20 },
    "robots.groups[]": { maxLength: 40 },
    "battery.below": { maximum: 1 },
    "battery.idle_s": { minimum: 10, maximum: 86400 },
    "schedule.times": { maxItems: 24 },
    "schedule.weekdays": { maxItems: 7 },
    "schedule.time_zone": { maxLength: 60 },
    "by": { maxLength: 60 },
  },
  "PUT /goals/{goal_id}/tags": {
    "tags": { maxItems: 10 },
    "tags[]": { maxLength: 30 },
  },
  "PUT /label": {
    "display_name": { maxLength: 60 },
    "groups": { maxItems: 20 },
    "groups[]": { maxLength: 40 },
  },
  "PUT /session/password": {
    "old": { minLength: 1, maxLength: 200 },
    "new": { minLength: 12, maxLength: 200 },
  },
  "PUT /webhooks/{webhook_id}": {
    "name": { maxLength: 60 },
    "url": { maxLength: 2000 },
    "severities": { maxItems: 2 },
    "robots.names": { maxItems: 500 },
    "robots.names[]": { maxLength: 255 },
    "robots.groups": { maxItems: 20 },
    "robots.groups[]": { maxLength: 40 },
    "by": { maxLength: 60 },
  },
} as const;
