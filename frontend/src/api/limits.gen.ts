// Made from openapi.json by `npm run types`.

/** By request, of those that a form is for: the limits of the fields of its body. */
export const LIMITS = {
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
  "PUT /robots/label": {
    "robot": { maxLength: 255 },
    "display_name": { maxLength: 60 },
    "groups": { maxItems: 20 },
    "groups[]": { maxLength: 40 },
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
