import elastin from './index.js';
export const {load, Elastin, Body, Simulation, ElastinError} = elastin;
export default elastin;
