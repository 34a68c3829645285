// Each extension is one line here and a folder of its name.
export { extension as audit_log } from "./extensions/audit_log/extension";
export { extension as automation } from "./extensions/automation/extension";
export { extension as cameras } from "./extensions/cameras/extension";
export { extension as chargers } from "./extensions/chargers/extension";
export { extension as maps } from "./extensions/maps/extension";
export { extension as missions } from "./extensions/missions/extension";
export { extension as recordings } from "./extensions/recordings/extension";
export { extension as simulator } from "./extensions/simulator/extension";
export { extension as single_sign_on } from "./extensions/single_sign_on/extension";
export { extension as sites } from "./extensions/sites/extension";
export { extension as statistics } from "./extensions/statistics/extension";
export { extension as webhooks } from "./extensions/webhooks/extension";
