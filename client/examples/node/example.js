// Creates a session of a tumbling spacecraft, goes to a step, and streams samples:
//
//     npm install && node example.js [HOST:PORT]
'use strict';
const {randomUUID} = require('crypto');
const {join} = require('path');
const {promisify} = require('util');
const grpc = require('@grpc/grpc-js');
const {loadSync} = require('@grpc/proto-loader');
const scene = require('../scenes/tumbling_spacecraft.json');

const {SimulationService} = grpc.loadPackageDefinition(loadSync('stiefel/v1/simulation.proto', {
  includeDirs: [join(__dirname, '../../../proto')], keepCase: true, longs: Number, enums: String, defaults: true,
})).stiefel.v1;
const client = new SimulationService(process.argv[2] || '127.0.0.1:50551', grpc.credentials.createInsecure());
const call = (name, request) => promisify(client[name]).call(client, request);

// The numbers of a tensor of doubles, in a buffer of their own because a message's bytes may stand anywhere.
const doubles = (tensor) => new Float64Array(new Uint8Array(tensor.data).buffer);
const print = (step, quaternion) => console.log(`step ${step}: ${quaternion.join(' ')}`);

async function main() {
  const session_id = randomUUID();
  await call('CreateSession', {session_id, scene});

  const {sample} = await call('Step', {session_id, to: 100, fields: ['quaternion']});
  print(sample.step, doubles(sample.fields[0].value));

  for await (const part of client.Stream({session_id, to: 1000, every: 250, fields: ['quaternion']})) {
    part.steps.forEach((step, k) => print(step, doubles(part.fields[0].value).slice(4 * k, 4 * k + 4)));
    if (part.run_status) console.log(part.run_status.outcome);
  }
  await call('DeleteSession', {session_id});
}

main().catch((error) => {
  console.error(error.message);
  process.exitCode = 1;
}).finally(() => client.close());
