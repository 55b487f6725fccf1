import elastin from './index.js';
export const {load, Elastin, Body, Simulation, Surface, ElastinError} = elastin;
export default elastin;
