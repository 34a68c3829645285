// Each extension is one line here and a folder of its name.
export { extension as cameras } from "./extensions/cameras/extension";
